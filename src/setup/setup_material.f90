!> MATErial: a law, small or finite strains, the formulation of ELEMents and BLOCks,
!! density, body force.
!!
!!   MATErial m
!!     SOLId
!!       ELAStic ISOTropic E nu | ELAStic NEOHook E nu
!!       SMALl | FINIte [VOLUme k]
!!       DISPlacement | ENHAnced
!!       DENSity rho        BODY b1 b2 b3        NURB interp q1 q2 q3
module setup_material
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, key_of
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use material_table, only: load_materials
  use material_type, only: material_t
  use model, only: material_set_t
  use setup_build, only: build_t, next_data
  use setup_law, only: draft_t, read_law, read_small, read_finite, put_together
  implicit none
  private
  public :: read_material, material_index

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

end module setup_material
