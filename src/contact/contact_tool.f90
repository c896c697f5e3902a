!> What a rigid surface feels: it is not integrated itself.
module contact_tool
  use base_kinds, only: wp
  use contact_work, only: element_functions
  use contact_foot, only: foot_t
  use contact_pair, only: surface_t
  implicit none
  private
  public :: react

contains

  !> A rigid tool is not integrated: its supports bear the tractions of the other side.
  subroutine react(tool, feet, traction, area, f)
    type(surface_t), intent(in) :: tool
    type(foot_t), intent(in) :: feet(:)          !! (nq)
    real(wp), intent(in) :: traction(:, :)       !! (3, nq) on the other side [F/L^2]
    real(wp), intent(in) :: area(:)              !! (nq) [L^2]
    real(wp), intent(inout) :: f(:, :)
    real(wp), allocatable :: shp(:), dshp(:, :)
    integer :: b, e, n, q

    do q = 1, size(feet)
      e = feet(q)%elem
      if (e == 0) cycle
      n = tool%first(e + 1) - tool%first(e)
      if (allocated(shp)) then
        if (size(shp) /= n) deallocate (shp, dshp)
      end if
      if (.not. allocated(shp)) allocate (shp(n), dshp(2, n))
      call element_functions(tool, e, feet(q)%xi, shp, dshp)
      do b = 1, n
        associate (node => tool%node(tool%first(e) + b - 1))
          f(:, node) = f(:, node) + shp(b)*area(q)*traction(:, q)
        end associate
      end do
    end do
  end subroutine react

end module contact_tool
