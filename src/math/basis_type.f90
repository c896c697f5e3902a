!> Shape functions and weights of one class of elements at its integration points.
module basis_type
  use base_kinds, only: wp
  implicit none
  private
  public :: basis_t

  !> All quantities refer to the parent coordinates in [-1,1]^3.
  type :: basis_t
    integer :: nen = 0   !! number of functions (nodes or control points)
    integer :: nq = 0    !! number of integration points
    integer :: nmode = 0 !! number of enhanced modes (0: no enhancement)
    real(wp), allocatable :: shp(:, :)      !! (nen, nq) values
    real(wp), allocatable :: dshp(:, :, :)  !! (3, nen, nq) parent derivatives
    real(wp), allocatable :: wgt(:)         !! (nq) weights of the rule
    real(wp), allocatable :: mode(:, :, :)  !! (3, nmode, nq) parent covectors of the enhanced modes
    real(wp), allocatable :: dshp0(:, :) !! (3, nen) parent derivatives at the centre (only with
    !! enhancement)
  end type basis_t

end module basis_type
