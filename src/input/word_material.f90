!> MATErial: a law, small or finite strains, the formulation of ELEMents and BLOCks, density, body
!! force.
!!
!!   MATErial m
!!     SOLId
!!       ELAStic ISOTropic E nu | ELAStic NEOHook E nu
!!       SMALl | FINIte [VOLUme k]
!!       DISPlacement | ENHAnced
!!       DENSity rho        BODY b1 b2 b3        NURB interp q1 q2 q3
!!
!! The table of material laws defines the laws and the numbers that they take.
module word_material
  use base_error, only: error_t, fail, DECK_ERROR, place_t
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, nearest, key_of
  use deck_feap, only: property_hint
  use deck_record, only: record_t, check_count, check_numbers
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, next_data
  use material_table, only: load_materials
  use material_type, only: material_t, material_usage, constant_error_t, MAX_PROP
  use model, only: material_set_t
  implicit none
  private
  public :: read_material, material_index

  !> The law and the type of strains as they were read. They are combined later, because their
  !! records may come in any order.
  type :: law_entry_t
    type(material_t) :: law                !! law; its name is empty until ELAStic is read
    integer :: strain = 0                  !! SMALL or FINITE
    integer :: nvalue = 0                  !! how many numbers are given
    real(wp) :: value(MAX_PROP + 1) = 0.0_wp
    type(place_t) :: place(MAX_PROP + 1)   !! place of each of them
    integer :: volume = 0                  !! k of VOLUme k
    logical :: volume_given = .false.
    type(place_t) :: strain_place, volume_place
  end type law_entry_t

  integer, parameter :: SMALL = 1, FINITE = 2
  character(12), parameter, public :: WORD(8) = [ &
                                      'ELAStic     ', 'SMALl       ', 'FINIte      ', &
                                      'DISPlacement', 'ENHAnced    ', 'DENSity     ', &
                                      'BODY        ', 'NURB        ']
  integer, parameter :: MAX_POINT = 16 !! integration points in a direction

contains

  !> Index of a material by the user's number; 0: there is none.
  pure integer function material_index(draft, number) result(i)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: number

    do i = size(draft%model%material), 1, -1
      if (draft%model%material(i)%number == number) return
    end do
  end function material_index

  subroutine read_material(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(material_set_t) :: set
    type(record_t) :: line
    logical :: more
    integer :: i

    call get_integer(deck, record, 2, set%number, error, 1)
    if (allocated(error)) return
    set%place = record%place(min(2, record%n))
    if (set%number < 1) then
      call fail(error, DECK_ERROR, 'the material number is '//to_text(set%number), set%place, &
                'material numbers must be positive')
      return
    end if
    i = material_index(draft, set%number)
    if (i > 0) then
      call fail(error, DECK_ERROR, 'duplicate material '//to_text(set%number), set%place, &
                'it is already defined in line '//to_text(draft%model%material(i)%place%line))
      return
    end if
    ! The material is added before its records are read, so that it is known even if one of them has
    ! an error.
    draft%model%material = [draft%model%material, set]
    call check_numbers(record, 3, 'MATErial m', error) ! FEAP allows a label there
    if (allocated(error)) return
    call next_data(draft, deck, line, more, error)
    if (allocated(error)) return
    if (.not. more) then
      call fail(error, DECK_ERROR, 'material '//to_text(set%number)//' is empty', set%place, &
                'add SOLId, then ELAStic and other properties')
      return
    end if
    if (line%key(1) /= 'soli') then
      call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(1))//' of material ' &
                //to_text(set%number), line%place(1), 'the only type is SOLId')
      return
    end if
    call check_count(line, 1, 1, 'SOLId takes no further fields', error)
    if (allocated(error)) return
    call read_properties(draft, deck, set, error)
    draft%model%material(size(draft%model%material)) = set
  end subroutine read_material

  !> Read records up to the blank one.
  subroutine read_properties(draft, deck, set, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    type(material_t), allocatable :: laws(:)
    type(law_entry_t) :: given
    type(record_t) :: line
    character(:), allocatable :: hint
    logical :: more, seen(size(WORD))
    integer :: w

    call load_materials(laws)
    seen = .false.
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      do w = size(WORD), 1, -1
        if (key_of(WORD(w)) == line%key(1)) exit
      end do
      if (w == 0) then
        hint = property_hint(line%text(1))
        if (len(hint) == 0) hint = 'nearest known: '//nearest(line%text(1), WORD)
        call fail(error, DECK_ERROR, 'unknown property '//quoted(line%text(1)), line%place(1), hint)
        return
      end if
      if (seen(w)) then
        call fail(error, DECK_ERROR, 'duplicate record '//trim(WORD(w))//' in material ' &
                  //to_text(set%number), line%place(1), 'keep one of them')
        return
      end if
      seen(w) = .true.
      select case (line%key(1))
      case ('elas')
        call read_law(deck, line, laws, given, error)
      case ('smal', 'fini')
        call read_strain(deck, line, given, error)
      case ('disp', 'enha')
        call check_count(line, 1, 1, 'DISPlacement and ENHAnced take no further fields', error)
        if (allocated(error)) return
        if (set%given_formulation) then
          call fail(error, DECK_ERROR, 'material '//to_text(set%number) &
                    //' is both DISPlacement and ENHAnced', line%place(1), 'keep one of them')
          return
        end if
        set%given_formulation = .true.
        set%enhanced = line%key(1) == 'enha'
      case ('dens') ! DENSity [a word] rho
        call check_count(line, 2, 3, 'DENSity rho', error)
        if (.not. allocated(error) .and. line%n > 2) then ! a decimal comma makes two numbers
          call check_numbers(line, 2, 'DENSity rho', error, last=2)
        end if
        if (.not. allocated(error)) call get_real(deck, line, line%n, set%density, error)
        if (allocated(error)) return
        if (set%density < 0.0_wp) call fail(error, DECK_ERROR, 'the density is ' &
                                            //to_text(set%density), line%place(line%n), &
                                            'a density must not be negative')
      case ('body')
        call read_body(deck, line, set, error)
      case default ! NURB
        call read_points(deck, line, set, error)
      end select
      if (allocated(error)) return
    end do
    call set_law(given, set, error)
  end subroutine read_properties

  !> Read BODY [FORCe] b1 b2 b3. FEAP ignores the field after BODY, whatever it contains.
  subroutine read_body(deck, line, set, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    integer :: d, first

    first = 3
    if (line%key(2) == 'heat') then
      call fail(error, DECK_ERROR, 'expected BODY FORCe, found a heat source, BODY HEAT', &
                line%place(2), "heat flow is not available: write 'BODY FORCe b1 b2 b3'")
      return
    end if
    if (.not. (line%is_empty(2) .or. line%key(2) == 'forc')) first = 2
    if (first == 2 .and. line%n >= 5) then
      call fail(error, DECK_ERROR, 'expected FORCe after BODY, found '//quoted(line%text(2)), &
                line%place(2), 'BODY FORCe b1 b2 b3')
      return
    end if
    call check_count(line, 2, first + 2, 'BODY FORCe b1 b2 b3', error)
    if (allocated(error)) return
    do d = 1, 3
      call get_real(deck, line, first + d - 1, set%body_force(d), error, 0.0_wp)
      if (allocated(error)) return
    end do
  end subroutine read_body

  !> Read NURB interp q1 q2 q3: Gauss points in the three directions of an NPATch; 0 means 5
  !! (igaFEAP).
  subroutine read_points(deck, line, set, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call check_count(line, 2, 5, 'NURB interp q1 q2 q3', error)
    if (allocated(error)) return
    if (line%key(2) /= 'inte') then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(2))//' of NURB', &
                line%place(2), 'NURB interp q1 q2 q3')
      return
    end if
    do d = 1, 3
      call get_integer(deck, line, d + 2, set%nurbs_points(d), error, 0)
      if (allocated(error)) return
      if (set%nurbs_points(d) < 0 .or. set%nurbs_points(d) > MAX_POINT) then
        call fail(error, DECK_ERROR, 'expected 1 to '//to_text(MAX_POINT)//' integration points, ' &
                  //'found '//to_text(set%nurbs_points(d)), line%place(d + 2), &
                  'NURB interp gives the numbers of points in the three directions')
        return
      end if
      if (set%nurbs_points(d) == 0) set%nurbs_points(d) = 5
    end do
  end subroutine read_points

  !> Read ELAStic, the law and its numbers.
  subroutine read_law(deck, line, laws, given, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_t), intent(in) :: laws(:)
    type(law_entry_t), intent(inout) :: given
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: prop(MAX_PROP)
    character(:), allocatable :: names
    integer :: i

    names = ''
    do i = 1, size(laws)
      names = names//' '//trim(laws(i)%name)
      if (key_of(laws(i)%name) == line%key(2)) given%law = laws(i)
    end do
    if (given%law%name == '') then
      call fail(error, DECK_ERROR, 'unknown law '//quoted(line%text(2)), line%place(2), &
                'known laws:'//names)
      return
    end if
    given%nvalue = given%law%nvalue
    call check_count(line, given%nvalue + 2, given%nvalue + 2, material_usage(given%law), error)
    if (allocated(error)) return
    do i = 1, given%nvalue
      call get_real(deck, line, i + 2, given%value(i), error)
      if (allocated(error)) return
      given%place(i) = line%place(i + 2)
    end do
    call set_properties(given, prop, error) ! wrong numbers are reported before later records
  end subroutine read_law

  !> Read SMALl, or FINIte [VOLUme k].
  subroutine read_strain(deck, line, given, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(law_entry_t), intent(inout) :: given
    type(error_t), allocatable, intent(out) :: error
    integer :: strain

    strain = merge(SMALL, FINITE, line%key(1) == 'smal')
    if (strain == SMALL) call check_count(line, 1, 1, 'SMALl takes no further fields', error)
    if (allocated(error)) return
    if (given%strain /= 0) then
      call fail(error, DECK_ERROR, 'the material is both SMALl and FINIte', line%place(1), &
                'keep one of them')
      return
    end if
    given%strain = strain
    given%strain_place = line%place(1)
    if (line%n == 1) return
    if (line%key(2) /= 'volu') then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(2))//' of FINIte', &
                line%place(2), 'FINIte [VOLUme k]')
      return
    end if
    call check_count(line, 3, 3, 'FINIte [VOLUme k]', error)
    if (allocated(error)) return
    call get_integer(deck, line, 3, given%volume, error)
    given%volume_given = .true.
    given%volume_place = line%place(3)
  end subroutine read_strain

  !> Set the law and its properties. Fail unless ELAStic, SMALl, FINIte and VOLUme are compatible.
  subroutine set_law(given, set, error)
    type(law_entry_t), intent(inout) :: given
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error

    if (given%law%name == '') then
      call fail(error, DECK_ERROR, 'material '//to_text(set%number)//' has no law', set%place, &
                'add '//laws_of([.true., .false.]))
      return
    end if
    set%row = given%law
    if (given%strain /= 0 .and. (given%strain == FINITE .neqv. set%row%finite)) then
      call fail(error, DECK_ERROR, trim(set%row%name)//' is a law of ' &
                //trim(merge('finite', 'small ', set%row%finite))//' strains', given%strain_place, &
                'write '//trim(merge('FINIte', 'SMALl ', set%row%finite)) &
                //', or use '//laws_of([.not. set%row%finite]))
      return
    end if
    if (given%volume_given) then
      if (.not. set%row%volumetric) then
        call fail(error, DECK_ERROR, trim(set%row%name)//' does not offer a choice of volumetric ' &
                  //'functions', given%volume_place, 'remove VOLUme')
        return
      end if
      given%nvalue = given%nvalue + 1
      given%value(given%nvalue) = given%volume
      given%place(given%nvalue) = given%volume_place
    end if
    call set_properties(given, set%prop, error)
  end subroutine set_law

  !> For a hint, list the records that choose a law for finite strains, for small strains, or for
  !! either.
  function laws_of(finite) result(text)
    logical, intent(in) :: finite(:)
    character(:), allocatable :: text
    type(material_t), allocatable :: law(:)
    integer :: i

    text = ''
    call load_materials(law)
    do i = 1, size(law)
      if (.not. any(finite .eqv. law(i)%finite)) cycle
      if (text /= '') text = text//', or '
      text = text//material_usage(law(i))
    end do
  end function laws_of

  !> Set the properties from the numbers read so far. An error is reported at the place of the
  !! rejected number.
  subroutine set_properties(given, prop, error)
    type(law_entry_t), intent(in) :: given
    real(wp), intent(out) :: prop(:)
    type(error_t), allocatable, intent(out) :: error
    type(constant_error_t) :: wrong

    call given%law%set(given%value(:given%nvalue), prop, wrong)
    if (wrong%value == 0) return
    call fail(error, DECK_ERROR, trim(wrong%message), given%place(wrong%value), trim(wrong%hint))
  end subroutine set_properties

end module word_material
