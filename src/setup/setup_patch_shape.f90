!> The records of a PATCh that say what it is and where: BOX, HEMIsphere, NPATch, FILE, ROTAte,
!! TRANslate.
module setup_patch_shape
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t, get_integer, get_real
  use patch_file, only: read_patch_file
  use patch_spec, only: patch_spec_t, placement_t, GEO_BOX, GEO_HEMISPHERE, GEO_NURBS
  use setup_build, only: patch_entry_t
  implicit none
  private
  public :: read_geometry, read_placement, read_reals

  real(wp), parameter :: DEGREE = acos(-1.0_wp)/180.0_wp

contains

  !> BOX, HEMIsphere, NPATch or FILE.
  subroutine read_geometry(deck, line, patch, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error

    select case (line%key(1))
    case ('box')
      call read_box(deck, line, patch%spec, error)
    case ('hemi')
      call read_hemisphere(deck, line, patch%spec, error)
    case ('npat')
      call check_count(line, 2, 2, 'NPATch k, the k-th solid of the NPATch records', error)
      if (allocated(error)) return
      call get_integer(deck, line, 2, patch%npatch, error)
      if (allocated(error)) return
      patch%npatch_place = line%place(2)
      if (patch%npatch < 1) call fail(error, DECK_ERROR, 'NPATch '//to_text(patch%npatch), &
                                      line%place(2), 'NPATch solids are counted from 1')
      patch%spec%geometry = GEO_NURBS
    case default ! FILE
      call check_count(line, 2, 3, 'FILE path [name]', error)
      if (allocated(error)) return
      call read_patch_file(resolve_path(line, 2), line%text(3), patch%spec%nurbs, line%place(2), &
                           error)
      patch%spec%geometry = GEO_NURBS
    end select
  end subroutine read_geometry

  !> BOX x0 y0 z0  lx ly lz.
  subroutine read_box(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6)
    integer :: i

    call check_count(line, 7, 7, 'BOX x0 y0 z0  lx ly lz', error)
    if (.not. allocated(error)) call read_reals(deck, line, 2, x, error)
    if (allocated(error)) return
    do i = 4, 6
      if (x(i) > 0.0_wp) cycle
      call fail(error, DECK_ERROR, 'a box of length '//to_text(x(i))//' in direction ' &
                //to_text(i - 3), line%place(i + 1), 'lengths are positive')
      return
    end do
    spec%geometry = GEO_BOX
    spec%origin = x(:3)
    spec%length = x(4:)
  end subroutine read_box

  !> HEMIsphere radius thickness [x0 y0 z0].
  subroutine read_hemisphere(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(5)

    x = 0.0_wp
    call check_count(line, 3, 6, 'HEMIsphere radius thickness [x0 y0 z0]', error)
    if (.not. allocated(error)) call read_reals(deck, line, 2, x(:line%n - 1), error)
    if (allocated(error)) return
    if (.not. x(1) > 0.0_wp) then
      call fail(error, DECK_ERROR, 'a hemisphere of radius '//to_text(x(1)), line%place(2), &
                'the radius is positive')
      return
    else if (.not. (x(2) > 0.0_wp .and. x(2) < x(1))) then
      call fail(error, DECK_ERROR, 'a hemisphere of radius '//to_text(x(1))//' and thickness ' &
                //to_text(x(2)), line%place(3), 'the thickness lies between 0 and the radius')
      return
    end if
    spec%geometry = GEO_HEMISPHERE
    spec%radius = x(1)
    spec%thickness = x(2)
    spec%origin = x(3:5)
  end subroutine read_hemisphere

  subroutine read_reals(deck, line, first, x, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: first
    real(wp), intent(inout) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(x)
      call get_real(deck, line, first + i - 1, x(i), error)
      if (allocated(error)) return
    end do
  end subroutine read_reals

  !> ROTAte px py pz  ax ay az  deg, or TRANslate dx dy dz.
  subroutine read_placement(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    type(placement_t) :: p
    real(wp) :: x(7), length

    p%rotates = line%key(1) == 'rota'
    if (p%rotates) then
      call check_count(line, 8, 8, 'ROTAte px py pz  ax ay az  degrees', error)
      if (.not. allocated(error)) call read_reals(deck, line, 2, x, error)
      if (allocated(error)) return
      length = norm2(x(4:6))
      if (.not. length > 0.0_wp) then
        call fail(error, DECK_ERROR, 'the axis of rotation has no length', line%place(5), &
                  'ROTAte px py pz  ax ay az  degrees')
        return
      end if
      p%point = x(:3)
      p%axis = x(4:6)/length
      p%angle = x(7)*DEGREE
    else
      call check_count(line, 4, 4, 'TRANslate dx dy dz', error)
      if (.not. allocated(error)) call read_reals(deck, line, 2, p%point, error)
      if (allocated(error)) return
    end if
    spec%placement = [spec%placement, p]
  end subroutine read_placement

end module setup_patch_shape
