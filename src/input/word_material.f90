!> MATErial: a law, small or finite strains, the formulation of ELEMents and BLOCks,
!! density, body force.
!!
!!   MATErial m
!!     SOLId
!!       ELAStic ISOTropic E nu | ELAStic NEOHook E nu
!!       SMALl | FINIte [VOLUme k]
!!       DISPlacement | ENHAnced
!!       DENSity rho        BODY b1 b2 b3        NURB interp q1 q2 q3
!!
!! The law of a material: which one, its numbers, small or finite strains.
!!
!! Which laws there are, and which numbers they need, is the table of laws' to say.
module word_material
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR, place_t
  use base_text, only: to_text, quoted, nearest, key_of
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use material_table, only: load_materials
  use material_type, only: material_t
  use model, only: material_set_t
  use input_draft, only: build_t, next_data
  implicit none
  private
  public :: read_material, material_index, draft_t, read_law, read_small, read_finite, &
            put_together

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

  character(12), parameter :: WORD(8) = &
                              ['ELAStic     ', 'SMALl       ', 'FINIte      ', 'DISPlacement', &
                               'ENHAnced    ', 'DENSity     ', 'BODY        ', 'NURB        ']
  integer, parameter :: MAX_POINT = 16 !! of a direction

contains

  !> Index of a material by the user's number; 0: there is none.
  pure integer function material_index(build, number) result(i)
    type(build_t), intent(in) :: build
    integer, intent(in) :: number

    do i = size(build%model%material), 1, -1
      if (build%model%material(i)%number == number) return
    end do
  end function material_index

  subroutine read_material(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(material_set_t) :: set
    type(record_t) :: line
    logical :: more

    call get_integer(deck, record, 2, set%number, error, 1)
    if (allocated(error)) return
    set%place = record%place(min(2, record%n))
    if (set%number < 1) then
      call fail(error, DECK_ERROR, 'material number '//to_text(set%number), set%place, &
                'numbers are positive')
      return
    end if
    if (material_index(build, set%number) > 0) then
      call fail(error, DECK_ERROR, 'material '//to_text(set%number)//' is defined twice', &
                set%place, 'the first one stands in line ' &
                //to_text(build%model%material(material_index(build, set%number))%place%line))
      return
    end if
    call append(build, set) ! before its records are read: an error in them must not make it unknown
    call next_data(build, deck, line, more, error)
    if (allocated(error)) return
    if (.not. more) then
      call fail(error, DECK_ERROR, 'material '//to_text(set%number)//' is empty', set%place, &
                'SOLId, then ELAStic and other properties')
      return
    end if
    if (line%key(1) /= 'soli') then
      call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(1))//' of material ' &
                //to_text(set%number), line%place(1), 'the only type is SOLId')
      return
    end if
    call check_count(line, 1, 1, 'SOLId stands alone', error)
    if (allocated(error)) return
    call read_properties(build, deck, set, error)
    build%model%material(size(build%model%material)) = set
  end subroutine read_material

  subroutine append(build, set)
    type(build_t), intent(inout) :: build
    type(material_set_t), intent(in) :: set
    type(material_set_t), allocatable :: longer(:)
    integer :: n

    n = size(build%model%material)
    allocate (longer(n + 1))
    longer(:n) = build%model%material
    longer(n + 1) = set
    call move_alloc(longer, build%model%material)
  end subroutine append

  !> Records up to the blank one.
  subroutine read_properties(build, deck, set, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    type(material_t), allocatable :: laws(:)
    type(draft_t) :: draft
    type(record_t) :: line
    logical :: more, seen(size(WORD))
    integer :: w

    call load_materials(laws)
    seen = .false.
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      do w = size(WORD), 1, -1
        if (key_of(WORD(w)) == line%key(1)) exit
      end do
      if (w == 0) then
        call fail(error, DECK_ERROR, 'unknown property '//quoted(line%text(1)), line%place(1), &
                  'nearest known: '//nearest(line%text(1), WORD))
        return
      end if
      if (seen(w)) then
        call fail(error, DECK_ERROR, trim(WORD(w))//' stands twice in material ' &
                  //to_text(set%number), &
                  line%place(1), 'keep one of them')
        return
      end if
      seen(w) = .true.
      call read_property(deck, line, laws, draft, set, error)
      if (allocated(error)) return
    end do
    call put_together(laws, draft, set, error)
  end subroutine read_properties

  !> One record.
  subroutine read_property(deck, line, laws, draft, set, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_t), intent(in) :: laws(:)
    type(draft_t), intent(inout) :: draft
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error

    select case (line%key(1))
    case ('elas')
      call read_law(deck, line, laws, draft, error)
    case ('smal')
      call read_small(line, draft, error)
    case ('fini')
      call read_finite(deck, line, draft, error)
    case ('disp', 'enha')
      call check_count(line, 1, 1, 'DISPlacement or ENHAnced stands alone', error)
      if (allocated(error)) return
      if (set%given_formulation) then
        call fail(error, DECK_ERROR, 'material '//to_text(set%number) &
                  //' is both DISPlacement and ENHAnced', &
                  line%place(1), 'keep one of them')
        return
      end if
      set%given_formulation = .true.
      set%enhanced = line%key(1) == 'enha'
    case ('dens')
      call read_density(deck, line, set, error)
    case ('body')
      call read_body(deck, line, set, error)
    case default ! NURB
      call read_points(deck, line, set, error)
    end select
  end subroutine read_property

  !> DENSity [a word] rho.
  subroutine read_density(deck, line, set, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 2, 3, 'DENSity rho', error)
    if (allocated(error)) return
    call get_real(deck, line, line%n, set%density, error)
    if (allocated(error)) return
    if (set%density < 0.0_wp) call fail(error, DECK_ERROR, 'the density is ' &
                                        //to_text(set%density), &
                                        line%place(line%n), 'a density is not negative')
  end subroutine read_density

  !> BODY [FORCe] b1 b2 b3. FEAP passes over the field behind BODY.
  subroutine read_body(deck, line, set, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(material_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    integer :: d, first

    first = 3
    if (line%key(2) == 'heat') then
      call fail(error, DECK_ERROR, 'BODY HEAT is a heat source', line%place(2), &
                'this program solves no heat flow: BODY FORCe b1 b2 b3')
      return
    end if
    if (.not. (line%is_empty(2) .or. line%key(2) == 'forc' .or. line%n >= 5)) first = 2
    call check_count(line, 2, first + 2, 'BODY FORCe b1 b2 b3', error)
    if (allocated(error)) return
    do d = 1, 3
      call get_real(deck, line, first + d - 1, set%body_force(d), error, 0.0_wp)
      if (allocated(error)) return
    end do
  end subroutine read_body

  !> NURB interp q1 q2 q3: Gauss points in the three directions of an NPATch; 0: 5 (igaFEAP).
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
                line%place(2), &
                'NURB interp q1 q2 q3')
      return
    end if
    do d = 1, 3
      call get_integer(deck, line, d + 2, set%nurbs_points(d), error, 0)
      if (allocated(error)) return
      if (set%nurbs_points(d) < 0 .or. set%nurbs_points(d) > MAX_POINT) then
        call fail(error, DECK_ERROR, to_text(set%nurbs_points(d))//' integration points', &
                  line%place(d + 2), &
                  '1 to '//to_text(MAX_POINT)//' points in each direction')
        return
      end if
      if (set%nurbs_points(d) == 0) set%nurbs_points(d) = 5
    end do
  end subroutine read_points

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

end module word_material
