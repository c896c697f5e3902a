!> The law of a material: which one, its numbers, small or finite strains.
!!
!! Which laws there are, and which numbers they need, is the table of laws' to say.
module setup_law
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, key_of
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use material_type, only: material_t
  use model, only: material_set_t
  implicit none
  private
  public :: draft_t, read_law, read_small, read_finite, put_together

  integer, parameter :: MAX_VALUE = 16

  !> What the records said, before it is put together.
  type :: draft_t
    integer :: law = 0                     !! row of the table of laws
    type(place_t) :: law_place, strain_place, volume_place
    integer :: strain = 0                  !! 1: SMALl, 2: FINIte
    integer :: volume = 0                  !! VOLUme k
    integer :: nvalue = 0
    real(wp) :: value(MAX_VALUE) = 0.0_wp
  end type draft_t

contains

  !> ELAStic law values.
  subroutine read_law(deck, line, laws, draft, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_t), intent(in) :: laws(:)
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error
    character(8) :: name(MAX_VALUE)
    integer :: i, n

    do i = size(laws), 1, -1
      if (key_of(laws(i)%name) == line%key(2)) exit
    end do
    if (i == 0) then
      call fail(error, DECK_ERROR, 'unknown law '//quoted(line%text(2)), line%place(2), &
                'known laws: '//law_names(laws))
      return
    end if
    draft%law = i
    draft%law_place = line%place(2)
    call value_names(laws(i)%usage, name, n)
    call check_count(line, n + 2, n + 2, trim(laws(i)%usage), error)
    if (allocated(error)) return
    draft%nvalue = n
    do i = 1, n
      call get_real(deck, line, i + 2, draft%value(i), error)
      if (allocated(error)) return
      call check_value(name(i), draft%value(i), line%place(i + 2), error)
      if (allocated(error)) return
    end do
  end subroutine read_law

  !> Bounds of the constants that every law shares.
  subroutine check_value(name, x, place, error)
    character(*), intent(in) :: name
    real(wp), intent(in) :: x
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error

    select case (name)
    case ('E')
      if (.not. x > 0.0_wp) call fail(error, DECK_ERROR, "Young's modulus is "//to_text(x), place, &
                                      'E is positive')
    case ('nu')
      if (.not. (x > -1.0_wp .and. x < 0.5_wp)) then
        call fail(error, DECK_ERROR, "Poisson's ratio is "//to_text(x), place, &
                  'nu lies between -1 and 0.5, without the ends')
      end if
    case default
      continue ! no bound that all laws share
    end select
  end subroutine check_value

  !> Names of the numbers of a law: the words between its name and / in `usage`.
  pure subroutine value_names(usage, name, n)
    character(*), intent(in) :: usage
    character(8), intent(out) :: name(:)
    integer, intent(out) :: n
    integer :: i, j, word

    name = ''
    n = 0
    word = 0
    i = 1
    do while (i <= len_trim(usage))
      if (usage(i:i) == '/') exit
      j = scan(usage(i:)//' ', ' ') + i - 2
      if (j >= i) then
        word = word + 1
        if (word > 2 .and. n < size(name)) then
          n = n + 1
          name(n) = usage(i:j)
        end if
      end if
      i = max(i, j + 1) + 1
    end do
  end subroutine value_names

  function law_names(laws) result(names)
    type(material_t), intent(in) :: laws(:)
    character(:), allocatable :: names
    integer :: i

    names = ''
    do i = 1, size(laws)
      names = names//' '//trim(laws(i)%name)
    end do
    names = names(2:)
  end function law_names

  !> SMALl.
  subroutine read_small(line, draft, error)
    type(record_t), intent(in) :: line
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 1, 1, 'SMALl stands alone', error)
    if (.not. allocated(error)) call set_strain(line, 1, draft, error)
  end subroutine read_small

  !> SMALl or FINIte, not both.
  subroutine set_strain(line, strain, draft, error)
    type(record_t), intent(in) :: line
    integer, intent(in) :: strain
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error

    if (draft%strain /= 0 .and. draft%strain /= strain) then
      call fail(error, DECK_ERROR, 'the material is both SMALl and FINIte', line%place(1), &
                'keep one of them')
      return
    end if
    draft%strain = strain
    draft%strain_place = line%place(1)
  end subroutine set_strain

  !> FINIte [VOLUme k].
  subroutine read_finite(deck, line, draft, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error

    call set_strain(line, 2, draft, error)
    if (allocated(error) .or. line%n == 1) return
    if (line%key(2) /= 'volu') then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(2))//' of FINIte', &
                line%place(2), &
                'FINIte [VOLUme k]')
      return
    end if
    call check_count(line, 3, 3, 'FINIte [VOLUme k]', error)
    if (allocated(error)) return
    call get_integer(deck, line, 3, draft%volume, error)
    if (allocated(error)) return
    draft%volume_place = line%place(3)
    if (draft%volume < 1 .or. draft%volume > 3) then
      call fail(error, DECK_ERROR, 'volumetric function '//to_text(draft%volume), line%place(3), &
                'VOLUme is 1, 2 or 3; 3 is Lam/2 (ln J)^2')
    end if
  end subroutine read_finite

  !> The records must belong together.
  subroutine put_together(laws, draft, set, error)
    type(material_t), intent(in) :: laws(:)
    type(draft_t), intent(in) :: draft
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    integer :: n

    if (draft%law == 0) then
      call fail(error, DECK_ERROR, 'material '//to_text(set%number)//' has no law', set%place, &
                'give '//trim(laws(size(laws))%usage))
      return
    end if
    set%row = laws(draft%law)
    if (draft%strain == 1 .and. set%row%finite) then
      call fail(error, DECK_ERROR, trim(set%row%name)//' is a law of finite strains', &
                draft%strain_place, &
                'for SMALl strains use ELAStic ISOTropic E nu')
      return
    else if (draft%strain == 2 .and. .not. set%row%finite) then
      call fail(error, DECK_ERROR, trim(set%row%name)//' is a law of small strains', &
                draft%strain_place, &
                'for FINIte strains use ELAStic NEOHook E nu')
      return
    end if
    n = draft%nvalue
    if (draft%volume > 0) then
      if (index(set%row%usage, 'VOLUme') == 0) then
        call fail(error, DECK_ERROR, trim(set%row%name)//' has no volumetric function to choose', &
                  draft%volume_place, 'remove VOLUme')
        return
      end if
      n = n + 1
      call set%row%set([draft%value(:n - 1), real(draft%volume, wp)], set%prop)
    else
      call set%row%set(draft%value(:n), set%prop)
    end if
  end subroutine put_together

end module setup_law
