!> Where the elements of a patch begin and end: parameters of the ELEMents and KNOTs records.
module patch_breaks
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use bspline, only: span_list
  use patch_spec, only: patch_spec_t
  implicit none
  private
  public :: own_breaks, nurbs_breaks

contains

  !> Element ends of a box or hemisphere: whole numbers, or 0, the given knots, 1.
  subroutine own_breaks(spec, d, breaks, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: d
    real(wp), allocatable, intent(out) :: breaks(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (allocated(spec%knots(d)%u)) then
      breaks = [0.0_wp, spec%knots(d)%u, 1.0_wp]
      call check_rising(spec, d, breaks, error)
    else
      breaks = [(real(i, wp), i=0, spec%nelem(d))] ! whole numbers: equal spans are equal to the bit
    end if
  end subroutine own_breaks

  subroutine check_rising(spec, d, breaks, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: d
    real(wp), intent(in) :: breaks(:)
    type(error_t), allocatable, intent(out) :: error

    if (all(breaks(2:) > breaks(:size(breaks) - 1))) return
    call fail(error, DECK_ERROR, 'knots of direction '//to_text(d)//" of patch '"//spec%name &
              //"' do not rise from "//to_text(breaks(1))//' to '//to_text(breaks(size(breaks))), &
              spec%place, 'KNOTs,dir lists the interior knots only, each once')
  end subroutine check_rising

  !> Element ends of a NURBS patch and the knots to insert.
  subroutine nurbs_breaks(spec, d, breaks, insert, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: d
    real(wp), allocatable, intent(out) :: breaks(:), insert(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: old(:)
    integer, allocatable :: k(:)
    integer :: e, i, m

    associate (s => spec%nurbs%dir(d))
      call span_list(s, k)
      old = [s%knots(k), s%knots(size(s%knots))]
    end associate
    if (allocated(spec%knots(d)%u)) then
      call graded_breaks(spec, d, old, breaks, insert, error)
      return
    end if
    m = spec%nelem(d)/size(k)
    if (m*size(k) /= spec%nelem(d)) then
      call fail(error, DECK_ERROR, &
                to_text(spec%nelem(d))//' elements in direction '//to_text(d)//" of patch '" &
                //spec%name//"', which has "//to_text(size(k))//' knot spans', spec%place, &
                'give a multiple of '//to_text(size(k))//', or KNOTs,'//to_text(d)//' list')
      return
    end if
    breaks = [((old(e) + (old(e + 1) - old(e))*i/m, i=0, m - 1), e=1, size(k)), &
              old(size(old))]
    insert = pack(breaks, [(mod(e - 1, m) /= 0, e=1, size(breaks))])
  end subroutine nurbs_breaks

  !> The same for a KNOTs list, which has to hold the knots of the patch.
  subroutine graded_breaks(spec, d, old, breaks, insert, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: d
    real(wp), intent(in) :: old(:)
    real(wp), allocatable, intent(out) :: breaks(:), insert(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), parameter :: SAME = 1.0e-10_wp ! of the range: the same knot in fewer digits
    logical, allocatable :: is_old(:)
    integer :: i, j

    breaks = [old(1), spec%knots(d)%u, old(size(old))]
    call check_rising(spec, d, breaks, error)
    if (allocated(error)) return
    allocate (is_old(size(breaks)), source=.false.)
    do i = 1, size(old)
      j = minloc(abs(breaks - old(i)), 1)
      if (abs(breaks(j) - old(i)) > SAME*(old(size(old)) - old(1))) then
        call fail(error, DECK_ERROR, "patch '"//spec%name//"' has a knot at "//to_text(old(i)) &
                  //' in direction '//to_text(d)//' that KNOTs leaves out', spec%place, &
                  'knots cannot be removed: add it to the list')
        return
      end if
      breaks(j) = old(i)
      is_old(j) = .true.
    end do
    insert = pack(breaks,.not. is_old)
  end subroutine graded_breaks

end module patch_breaks
