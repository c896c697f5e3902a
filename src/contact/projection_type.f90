!> Where a point stands above a surface: what projection hands to the laws' kinematics.
module projection_type
  use base_kinds, only: wp
  implicit none
  private
  public :: foot_t, shape_t, touches

  !> A surface where it is now.
  type :: shape_t
    !> (3, nb, nelem) Bezier points [L], nb of the richest basis; rational surfaces: divided by their
    !! weights
    real(wp), allocatable :: bez(:, :, :)
    real(wp), allocatable :: w(:, :)        !! (nb, nelem) weights of them; not allocated: all one
    real(wp), allocatable :: low(:, :), high(:, :) !! (3, nelem) box round each element
  end type shape_t

  !> Closest point of a surface.
  type :: foot_t
    integer :: elem = 0                     !! 0: none, the point lies off the surface
    real(wp) :: xi(2) = 0.0_wp
    !> Which parameters move freely: both on a smooth surface, one on an interior edge of facets,
    !! none on a vertex.
    logical :: free(2) = .true.
    real(wp) :: x(3) = 0.0_wp               !! position [L]
    real(wp) :: a(3, 2) = 0.0_wp            !! tangents
    real(wp) :: b(3, 3) = 0.0_wp            !! second derivatives 11, 22, 12
    real(wp) :: n(3) = 0.0_wp !! unit outward normal; mean of the facets' on an edge or vertex
    !> Where there is no foot: closest point of the outer boundary, if it is near; element 0: none.
    integer :: border = 0
    real(wp) :: border_xi(2) = 0.0_wp
    real(wp) :: border_gap = 0.0_wp         !! [L] height above the tangent plane there
    real(wp) :: gap = huge(1.0_wp) !! [L] negative inside; on an edge or vertex the distance with
    !! that sign
  end type foot_t

contains

  !> There is a foot, and the point not deeper below it than `depth`.
  pure logical function touches(foot, depth)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: depth           !! [L]

    touches = foot%elem > 0
    if (touches) touches = foot%gap >= -depth
  end function touches

end module projection_type
