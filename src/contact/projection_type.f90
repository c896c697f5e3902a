!> Result of a projection, as needed for the kinematics of contact, and the shape of a surface.
module projection_type
  use base_kinds, only: wp
  implicit none
  private
  public :: foot_t, shape_t, touches

  !> Current geometry of a surface (surface_geometry).
  type :: shape_t
    !> (3, nb, nelem) Bezier points [L], where nb is the largest number of Bernstein polynomials of
    !! an element
    real(wp), allocatable :: bez(:, :, :)
    real(wp), allocatable :: w(:, :)  !! (nb, nelem) weights of the points; not allocated: all one
    real(wp), allocatable :: low(:, :), high(:, :) !! (3, nelem) box around each element [L]
  end type shape_t

  !> Projection of a point: the closest point of a surface.
  type :: foot_t
    integer :: elem = 0                     !! 0: there is no projection
    real(wp) :: xi(2) = 0.0_wp
    !> Parameters that vary with the point: both on a smooth surface, one on an interior edge that
    !! is a ridge, none at a vertex.
    logical :: free(2) = .true.
    real(wp) :: x(3) = 0.0_wp               !! position [L]
    real(wp) :: a(3, 2) = 0.0_wp            !! tangents
    real(wp) :: b(3, 3) = 0.0_wp            !! second derivatives 11, 22, 12
    real(wp) :: n(3) = 0.0_wp  !! unit outward normal; on ridges and at vertices the mean
    !! of those of the elements
    !> Gap: height of the point above the surface, negative inside; on a ridge or at a vertex, the
    !! distance with this sign [L].
    real(wp) :: gap = huge(1.0_wp)
    !> The closest point of the outer boundary, found if there is no projection. Element 0 means
    !! that no boundary is near.
    integer :: outer = 0
    real(wp) :: outer_xi(2) = 0.0_wp
    real(wp) :: outer_gap = 0.0_wp          !! [L] height above the tangent plane at this point
  end type foot_t

contains

  !> Is there a projection, and is the point no deeper below the surface than `depth`?
  pure logical function touches(foot, depth)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: depth           !! [L]

    touches = foot%elem > 0
    if (touches) touches = foot%gap >= -depth
  end function touches

end module projection_type
