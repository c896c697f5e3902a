!> What a CONTact, and the curves of it, refer to, before anything is meshed.
module setup_contact_check
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, nearest, lower
  use contact_spec, only: contact_spec_t
  use curve_type, only: Q_CONTACT_DEBONDED
  use setup_build, only: build_t, column_t
  use setup_contact, only: contact_named
  use setup_rigid, only: is_rigid_patch
  implicit none
  private
  public :: check_contacts

contains

  !> Errors go to the list. That the patches exist has been seen to.
  subroutine check_contacts(build)
    type(build_t), intent(inout) :: build
    type(error_t), allocatable :: error
    integer :: i, j

    do i = 1, size(build%contact)
      if (build%contact(i)%at(2)%kind == 0) cycle ! its own error is in the list
      call check_surfaces(build, build%contact(i), error)
      if (allocated(error)) call build%errors%add(error)
    end do
    do i = 1, build%ncurve
      do j = 1, size(build%curve(i)%column)
        if (.not. allocated(build%curve(i)%column(j)%contact)) cycle
        call check_column(build, build%curve(i)%column(j), error)
        if (allocated(error)) call build%errors%add(error)
      end do
    end do
  end subroutine check_contacts

  !> Two surfaces without a common face, at least one of which can be deformed.
  subroutine check_surfaces(build, contact, error)
    type(build_t), intent(in) :: build
    type(contact_spec_t), intent(in) :: contact
    type(error_t), allocatable, intent(out) :: error

    associate (a => contact%at(1), b => contact%at(2))
      if (lower(a%body) == lower(b%body) .and. &
          (iand(a%mask, b%mask) /= 0 .or. lower(a%face) == lower(b%face))) then
        call fail(error, DECK_ERROR, 'a face of patch '//quoted(b%body) &
                  //' is on both sides of contact '//quoted(contact%name), b%face_place, &
                  'the two surfaces have no face in common')
      else if (is_rigid_patch(build, a%body) .and. is_rigid_patch(build, b%body)) then
        call fail(error, DECK_ERROR, 'both bodies of contact '//quoted(contact%name) &
                  //' are rigid', b%place, 'give one of them a TYPE of solid elements')
      end if
    end associate
  end subroutine check_surfaces

  !> A contact of that name, with what the quantity needs.
  subroutine check_column(build, column, error)
    type(build_t), intent(in) :: build
    type(column_t), intent(in) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: c

    c = contact_named(build, column%contact)
    if (c == 0) then
      call fail(error, DECK_ERROR, 'contact '//quoted(column%contact)//' is not defined', &
                column%contact_place, known_contacts(build, column%contact))
      return
    end if
    if (build%contact(c)%at(2)%kind == 0) return ! its own error is in the list
    if (column%quantity%kind == Q_CONTACT_DEBONDED .and. .not. build%contact(c)%cohesive%given) then
      call fail(error, DECK_ERROR, 'contact '//quoted(column%contact)//' has no COHEsive', &
                column%contact_place, 'DEBOnded is a share of what COHEsive holds together')
    end if
  end subroutine check_column

  function known_contacts(build, name) result(hint)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name
    character(:), allocatable :: hint
    character(32), allocatable :: names(:)
    integer :: i

    hint = 'the deck has no CONTact'
    if (size(build%contact) == 0) return
    allocate (names(size(build%contact)))
    do i = 1, size(names)
      names(i) = build%contact(i)%name
    end do
    hint = 'nearest known: '//trim(nearest(name, names))
  end function known_contacts

end module setup_contact_check
