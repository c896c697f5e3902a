!> NORMal, FRICtion and COHEsive: reads the laws of a contact, their parameters and their options.
!!
!! The laws are those of the table of contact laws. Checks and hints of the options use the lists
!! below.
module word_contact_law
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, key_of
  use contact_pair, only: assigned_law_t
  use contact_table, only: load_contact_laws
  use contact_type, only: contact_law_t, NORMAL, FRICTION, COHESIVE, PENALTY, SMOOTHING, MU, &
                          TANGENTIAL_PENALTY
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_real
  use input_draft, only: contact_entry_t
  use input_option, only: next_option, option_row, read_positive, with_options
  implicit none
  private
  public :: read_normal, read_friction, read_cohesive, set_usual_normal, law_usage

  !> Options, each with the value that follows it.
  character(*), parameter :: NORMAL_OPTION(3) = [character(8) :: 'PAIR', 'SMOOth d', 'BORDer w']
  character(*), parameter :: FRICTION_OPTION(1) = ['AFTEr time']
  character(*), parameter :: COHESIVE_OPTION(1) = ['VISCous tau']

contains

  !> The form of the record of a law with all of its options, for hints and --list.
  function law_usage(law) result(usage)
    type(contact_law_t), intent(in) :: law
    character(:), allocatable :: usage

    select case (law%role)
    case (NORMAL)
      usage = with_options(law%usage, NORMAL_OPTION)
    case (FRICTION)
      usage = with_options(law%usage, FRICTION_OPTION)
    case default
      usage = with_options(law%usage, cohesive_options(law))
    end select
  end function law_usage

  !> Options of a cohesive law: the options of the other rows with its name, and those that all
  !! cohesive laws have.
  function cohesive_options(law) result(option)
    type(contact_law_t), intent(in) :: law
    character(16), allocatable :: option(:)
    type(contact_law_t), allocatable :: table(:)
    integer :: i

    call load_contact_laws(table)
    allocate (option(0))
    do i = 1, size(table)
      if (table(i)%role == law%role .and. table(i)%name == law%name &
          .and. table(i)%option /= '') then
        option = [option, table(i)%option]
      end if
    end do
    do i = 1, size(COHESIVE_OPTION)
      option = [character(16) :: option, COHESIVE_OPTION(i)]
    end do
  end function cohesive_options

  !> Read NORMal PENAlty eps, or [PENAlty] AUTO [factor]; then the options.
  subroutine read_normal(deck, line, entry, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage
    character(4) :: key
    logical :: seen(size(NORMAL_OPTION))
    integer :: i

    associate (contact => entry%contact, law => entry%contact%normal)
      i = 2
      if (line%key(2) == 'auto') i = 1 ! AUTO alone means the first law
      call find_law(line, i, NORMAL, law, error)
      if (allocated(error)) return
      usage = law_usage(law%law)
      i = i + 1
      law%auto = line%key(i) == 'auto'
      if (law%auto) then
        if (line%n > i .and. option_row(NORMAL_OPTION, line%key(i + 1)) == 0) then
          i = i + 1
          call read_positive(deck, line, i, 'factor of AUTO', law%factor, error)
        end if
      else
        call check_count(line, i, huge(i), usage, error)
        if (.not. allocated(error)) call read_positive(deck, line, i, 'penalty', &
                                                       law%prop(PENALTY), error)
      end if
      seen = .false.
      do
        if (.not. allocated(error)) call next_option(line, i, NORMAL_OPTION, usage, seen, key, &
                                                     error)
        if (allocated(error)) return
        select case (key)
        case ('pair')
          contact%on_pair = .true.
          entry%pair_place = line%place(i)
        case ('smoo')
          i = i + 1
          call read_positive(deck, line, i, 'penetration of SMOOth', law%prop(SMOOTHING), error)
        case ('bord')
          i = i + 1
          call read_positive(deck, line, i, 'width of BORDer', contact%taper, error)
          if (.not. allocated(error) .and. contact%taper > 1.0_wp) then
            call fail(error, DECK_ERROR, 'the width of BORDer must be at most 1, found ' &
                      //to_text(contact%taper), line%place(i), &
                      "w of 'BORDer w' is a fraction of the width of an element")
          end if
        case default
          return
        end select
      end do
    end associate
  end subroutine read_normal

  !> The normal law of a contact without NORMal: NORMal PENAlty AUTO.
  subroutine set_usual_normal(law)
    type(assigned_law_t), intent(inout) :: law
    type(record_t) :: nothing
    type(error_t), allocatable :: error

    call find_law(nothing, 1, NORMAL, law, error)
    law%auto = .true.
  end subroutine set_usual_normal

  !> Read FRICtion COULomb mu, with PENAlty eps or PENAlty AUTO, which is the default; then the
  !! options.
  subroutine read_friction(deck, line, entry, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage
    character(4) :: key
    logical :: seen(size(FRICTION_OPTION))
    integer :: i

    associate (law => entry%contact%friction)
      call find_law(line, 2, FRICTION, law, error)
      if (allocated(error)) return
      usage = law_usage(law%law)
      call check_count(line, 3, huge(i), usage, error)
      if (.not. allocated(error)) call get_real(deck, line, 3, law%prop(MU), error)
      if (allocated(error)) return
      if (.not. law%prop(MU) >= 0.0_wp) then
        call fail(error, DECK_ERROR, 'the coefficient of friction must not be negative, found ' &
                  //to_text(law%prop(MU)), line%place(3), usage)
        return
      end if
      i = 3
      law%auto = line%key(4) /= 'pena'
      if (.not. law%auto) then
        i = 5
        law%auto = line%key(5) == 'auto'
        call check_count(line, 5, huge(i), usage, error)
        if (.not. (law%auto .or. allocated(error))) then
          call read_positive(deck, line, 5, 'tangential penalty', law%prop(TANGENTIAL_PENALTY), &
                             error)
        end if
      end if
    end associate
    seen = .false.
    do
      if (.not. allocated(error)) call next_option(line, i, FRICTION_OPTION, usage, seen, key, &
                                                   error)
      if (allocated(error)) return
      select case (key)
      case ('afte')
        i = i + 1
        call get_real(deck, line, i, entry%contact%after, error)
      case default
        return
      end select
    end do
  end subroutine read_friction

  !> Read COHEsive, the law and its parameters, which must all be positive; then the options, one of
  !! which may select another row of the law.
  subroutine read_cohesive(deck, line, entry, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error
    type(contact_law_t), allocatable :: table(:)
    character(16), allocatable :: option(:)
    character(:), allocatable :: usage, hint
    character(4) :: key
    logical, allocatable :: seen(:)
    integer :: i, j, n, wrong

    associate (law => entry%contact%cohesive)
      call find_law(line, 2, COHESIVE, law, error)
      if (allocated(error)) return
      usage = law_usage(law%law)
      n = law%law%nprop
      call check_count(line, n + 2, huge(n), usage, error)
      do i = 3, n + 2
        if (.not. allocated(error)) call read_positive(deck, line, i, 'parameter', &
                                                       law%prop(i - 2), error)
      end do
      i = n + 2
      option = cohesive_options(law%law)
      allocate (seen(size(option)), source=.false.)
      call load_contact_laws(table)
      do
        if (.not. allocated(error)) call next_option(line, i, option, usage, seen, key, error)
        if (allocated(error)) return
        select case (key)
        case ('')
          exit
        case ('visc')
          i = i + 1
          call read_positive(deck, line, i, 'time of VISCous', law%tau, error)
        case default
          do j = 1, size(table)
            if (table(j)%role == COHESIVE .and. table(j)%name == law%law%name .and. &
                key_of(table(j)%option) == key) exit
          end do
          law%law = table(j)
        end select
      end do
      if (.not. associated(law%law%prepare)) return
      call law%law%prepare(law%prop, wrong, hint)
      if (wrong > 0) call fail(error, DECK_ERROR, line%text(wrong + 2)//' is out of range', &
                               line%place(wrong + 2), hint)
    end associate
  end subroutine read_cohesive

  !> Find the law that field i names; if i is 1, the first law for the word of the record.
  subroutine find_law(line, i, role, law, error)
    type(record_t), intent(in) :: line
    integer, intent(in) :: i, role
    type(assigned_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    type(contact_law_t), allocatable :: table(:)
    character(:), allocatable :: known
    integer :: j

    call load_contact_laws(table)
    known = ''
    do j = 1, size(table)
      if (table(j)%role /= role .or. table(j)%option /= '') cycle
      known = known//' '//trim(table(j)%name)
      if (i > 1 .and. key_of(table(j)%name) /= line%key(i)) cycle
      law%law = table(j)
      law%given = .true.
      return
    end do
    known = 'known laws:'//known
    if (role == NORMAL) known = known//'; options follow it, as in NORMal PENAlty AUTO BORDer 0.2'
    if (line%is_empty(i)) then
      call fail(error, DECK_ERROR, 'the law of '//line%text(1)//' is missing', line%place(i), known)
    else
      call fail(error, DECK_ERROR, 'unknown law '//quoted(line%text(i))//' of '//line%text(1), &
                line%place(i), known)
    end if
  end subroutine find_law

end module word_contact_law
