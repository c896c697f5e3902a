!> The laws of a CONTact: the readers of NORMal, FRICtion and COHEsive. Which laws there are is
!! their table's to say.
module setup_contact_law
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, key_of
  use contact_spec, only: contact_spec_t, spec_law_t
  use contact_table, only: load_contact_laws
  use contact_type, only: contact_law_t, NORMAL, FRICTION, COHESIVE
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_real
  implicit none
  private
  public :: read_normal, read_friction, read_cohesive, read_positive

  character(4), parameter :: OPTION(3) = ['pair', 'smoo', 'bord'] !! of NORMal

contains

  !> NORMal PENAlty eps, or AUTO [factor]; then PAIR, SMOOth d and BORDer w in any order.
  subroutine read_normal(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    associate (law => contact%normal)
      i = 2
      if (line%key(2) == 'auto') then ! of the first law
        call find_law(line, 0, NORMAL, law, error)
      else
        call find_law(line, 2, NORMAL, law, error)
        i = 3
      end if
      if (allocated(error)) return
      if (line%key(i) == 'auto') then
        law%auto = .true.
        if (line%n > i .and. all(line%key(i + 1) /= OPTION)) then
          i = i + 1
          call read_positive(deck, line, i, 'factor of AUTO', law%factor, error)
        end if
      else
        call check_count(line, i, i + 5, trim(law%row%usage), error)
        if (.not. allocated(error)) call read_positive(deck, line, i, 'penalty', law%prop(1), error)
      end if
    end associate
    do while (.not. allocated(error) .and. i < line%n)
      call read_option(deck, line, i, contact, error)
    end do
  end subroutine read_normal

  !> One option of NORMal behind field i, which then is its last.
  subroutine read_option(deck, line, i, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(inout) :: i
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage

    usage = trim(contact%normal%row%usage)
    i = i + 1
    if (line%key(i) == 'pair' .and. .not. contact%on_pair) then
      contact%on_pair = .true.
      contact%pair_place = line%place(i)
    else if (line%key(i) == 'smoo' .and. .not. contact%normal%prop(2) > 0.0_wp) then
      i = i + 1
      call check_count(line, i, i + 3, usage, error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'penetration of SMOOth', &
                                                     contact%normal%prop(2), error)
    else if (line%key(i) == 'bord' .and. .not. contact%border > 0.0_wp) then
      i = i + 1
      call check_count(line, i, i + 3, usage, error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'width of BORDer', &
                                                     contact%border, error)
      if (allocated(error) .or. contact%border <= 1.0_wp) return
      call fail(error, DECK_ERROR, 'the width of BORDer is a share of an element, at most 1', &
                line%place(i), usage)
    else if (any(line%key(i) == OPTION)) then
      call fail(error, DECK_ERROR, line%text(i)//' stands twice', line%place(i), usage)
    else
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of NORMal', &
                line%place(i), usage)
    end if
  end subroutine read_option

  !> FRICtion COULomb mu PENAlty eps | AUTO [AFTEr time].
  subroutine read_friction(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage

    call find_law(line, 2, FRICTION, contact%friction, error)
    if (allocated(error)) return
    usage = trim(contact%friction%row%usage)
    associate (law => contact%friction)
      call check_count(line, 5, 7, usage, error)
      if (.not. allocated(error)) call get_real(deck, line, 3, law%prop(1), error)
      if (allocated(error)) return
      if (.not. law%prop(1) >= 0.0_wp) then
        call fail(error, DECK_ERROR, 'the coefficient of friction is '//to_text(law%prop(1)), &
                  line%place(3), 'it is not negative')
      else if (line%key(4) /= 'pena') then
        call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(4))//' of FRICtion', &
                  line%place(4), usage)
      else if (line%key(5) == 'auto') then
        law%auto = .true.
      else
        call read_positive(deck, line, 5, 'tangential penalty', law%prop(2), error)
      end if
      if (allocated(error) .or. line%n == 5) return
      if (line%key(6) /= 'afte') then
        call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(6))//' of FRICtion', &
                  line%place(6), usage)
        return
      end if
      call check_count(line, 7, 7, usage, error)
      if (.not. allocated(error)) call get_real(deck, line, 7, contact%after, error)
      contact%has_after = .true.
    end associate
  end subroutine read_friction

  !> COHEsive law and its numbers, all of them positive; then its options in any order.
  subroutine read_cohesive(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint
    integer :: i, n, wrong

    associate (law => contact%cohesive)
      call find_law(line, 2, COHESIVE, law, error)
      if (allocated(error)) return
      n = law%row%nprop
      call check_count(line, n + 2, n + 5, trim(law%row%usage), error)
      do i = 3, n + 2
        if (allocated(error)) return
        call read_positive(deck, line, i, 'number', law%prop(i - 2), error)
      end do
      i = n + 2
      do while (.not. allocated(error) .and. i < line%n)
        call read_cohesive_option(deck, line, i, law, error)
      end do
      if (allocated(error) .or. .not. associated(law%row%prepare)) return
      call law%row%prepare(law%prop, wrong, hint)
      if (wrong > 0) call fail(error, DECK_ERROR, line%text(wrong + 2)//' is out of range', &
                               line%place(wrong + 2), hint)
    end associate
  end subroutine read_cohesive

  !> One option behind field i, which then is its last: VISCous tau, or the word of another row of
  !! the same name.
  subroutine read_cohesive_option(deck, line, i, law, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(inout) :: i
    type(spec_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    type(contact_law_t), allocatable :: table(:)
    integer :: j

    i = i + 1
    if (line%key(i) == 'visc' .and. .not. law%tau > 0.0_wp) then
      i = i + 1
      call check_count(line, i, i + 1, trim(law%row%usage), error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'time of VISCous', law%tau, &
                                                     error)
      return
    end if
    call load_contact_laws(table)
    do j = 1, size(table)
      if (table(j)%role /= COHESIVE .or. table(j)%name /= law%row%name) cycle
      if (table(j)%option == law%row%option .or. table(j)%option == '') cycle
      if (key_of(table(j)%option) /= line%key(i)) cycle
      law%row = table(j)
      return
    end do
    call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of COHEsive', &
              line%place(i), trim(law%row%usage))
  end subroutine read_cohesive_option

  !> The row of the law in field i; i = 0: the first of its role.
  subroutine find_law(line, i, role, law, error)
    type(record_t), intent(in) :: line
    integer, intent(in) :: i, role
    type(spec_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    type(contact_law_t), allocatable :: table(:)
    character(:), allocatable :: known
    integer :: j

    call load_contact_laws(table)
    known = ''
    do j = 1, size(table)
      if (table(j)%role /= role .or. table(j)%option /= '') cycle
      known = known//' '//trim(table(j)%name)
      if (i > 0 .and. key_of(table(j)%name) /= line%key(max(i, 1))) cycle
      law%row = table(j)
      law%given = .true.
      return
    end do
    if (known == '') then
      call fail(error, DECK_ERROR, line%text(1)//' is not available yet', line%place(1), &
                'this version has no law for it')
    else if (line%is_empty(i)) then
      call fail(error, DECK_ERROR, 'the law of '//line%text(1)//' is missing', line%place(i), &
                'known laws:'//known)
    else
      call fail(error, DECK_ERROR, 'unknown law '//quoted(line%text(i))//' of '//line%text(1), &
                line%place(i), 'known laws:'//known)
    end if
  end subroutine find_law

  !> A number greater than zero.
  subroutine read_positive(deck, line, i, what, x, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    character(*), intent(in) :: what
    real(wp), intent(inout) :: x
    type(error_t), allocatable, intent(out) :: error

    call get_real(deck, line, i, x, error)
    if (allocated(error)) return
    if (x > 0.0_wp) return
    call fail(error, DECK_ERROR, 'the '//what//' is '//to_text(x), line%place(i), 'it is positive')
  end subroutine read_positive

end module setup_contact_law
