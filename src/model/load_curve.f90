!> Load tables: PROP.
module load_curve
  use base_kinds, only: wp
  implicit none
  private
  public :: load_table_t

  !> Factor over time. Kind 1: FEAP's formula; kind 2: straight lines between pairs.
  type :: load_table_t
    integer :: kind = 0                !! 0: p = t (a blank record alone)
    integer :: power = 1
    real(wp) :: tmin = 0.0_wp, tmax = 0.0_wp
    real(wp) :: a(5) = 0.0_wp
    real(wp), allocatable :: t(:), p(:)
  end type load_table_t

end module load_curve
