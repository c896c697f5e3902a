!> What rounding alone leaves of forces and energies, where a body is at rest or moves rigidly.
!!
!! Positions are known to epsilon of themselves, so a nodal force is known to epsilon times the
!! stiffness of the node times its displacement or its distance to its neighbours. Without this a
!! step in which nothing changes (a load held after unloading) is all noise and never passes a
!! relative test.
module rounding_floor
  use base_kinds, only: wp
  use csr, only: block_matrix_t, block_position
  use mesh, only: mesh_t
  implicit none
  private
  public :: floor_t, node_spacing, find_floor

  real(wp), parameter :: OF_FORCE = 16.0_wp*epsilon(1.0_wp)
  !> Of displacements: the softest motion of a slender body magnifies the rounding of the forces.
  real(wp), parameter :: OF_MOTION = 1.0e3_wp*epsilon(1.0_wp)

  type :: floor_t
    real(wp) :: force = 0.0_wp         !! of a nodal force [F]
    real(wp) :: energy = 0.0_wp        !! of |du.r| [F L]
  end type floor_t

contains

  !> Distance of every node to the nearest other node of its elements; 0: the node has no element.
  pure function node_spacing(mesh) result(spacing)
    type(mesh_t), intent(in) :: mesh
    real(wp) :: spacing(mesh%nnode)    !! [L]
    real(wp) :: d
    integer :: b, e, i, j

    spacing = 0.0_wp
    do b = 1, size(mesh%block)
      associate (conn => mesh%block(b)%conn)
        do e = 1, mesh%block(b)%nelem
          do i = 1, mesh%block(b)%nen
            do j = 1, i - 1
              d = norm2(mesh%xr(:, conn(i, e)) - mesh%xr(:, conn(j, e)))
              if (.not. d > 0.0_wp) cycle    ! collapsed
              call lower(spacing(conn(i, e)), d)
              call lower(spacing(conn(j, e)), d)
            end do
          end do
        end do
      end associate
    end do
  end function node_spacing

  pure subroutine lower(spacing, d)
    real(wp), intent(inout) :: spacing
    real(wp), intent(in) :: d

    if (spacing > 0.0_wp) then
      spacing = min(spacing, d)
    else
      spacing = d
    end if
  end subroutine lower

  !> The floor for the tangent and the displacements of now.
  pure function find_floor(k, spacing, u) result(floor)
    type(block_matrix_t), intent(in) :: k
    real(wp), intent(in) :: spacing(:)   !! (nnode) [L]
    real(wp), intent(in) :: u(:, :)      !! (3, nnode) [L]
    type(floor_t) :: floor
    real(wp) :: length
    integer :: i, n, p

    do n = 1, k%nnode
      p = block_position(k, n, n)
      if (p == 0) cycle
      length = norm2(u(:, n)) + spacing(n)
      do i = 1, 3
        floor%force = max(floor%force, OF_FORCE*abs(k%val(i, i, p))*length)
        floor%energy = floor%energy + abs(k%val(i, i, p))*(OF_MOTION*length)**2
      end do
    end do
  end function find_floor

end module rounding_floor
