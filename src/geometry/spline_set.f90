!> Named sets of elements of a spline surface. They are read from the member `sets` of a BEXT file
!! in JSON, and become groups of the body, to which FIX, loads and contact may refer.
module spline_set
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower, nearest
  use format_json, only: json_t, member, first_of, to_integer, JSON_LIST, JSON_OBJECT
  use format_text, only: text_t, fail_in_file
  use mesh, only: mesh_t
  use spline_surface, only: spline_surface_t, spline_set_t
  implicit none
  private
  public :: read_sets, check_set, put_sets

contains

  !> Read the optional member "sets": {"name": [elements from 0], ...} of a file.
  subroutine read_sets(text, json, surface, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    type(spline_surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(spline_set_t), allocatable :: set(:)
    logical :: found(surface%nelem)     ! marks the elements of the set that were read before
    integer :: e, i, list, n

    i = member(text, json, 1, 'sets')
    if (i == 0) return
    text%at = json%at(i)
    if (json%type(i) /= JSON_OBJECT) then
      call fail_in_file(text, '"sets" is not an object', error, 'write "sets": {"name": [0, 1]}')
      return
    end if
    allocate (set(json%length(i)))
    list = first_of(json, i)
    do n = 1, size(set)
      associate (key => json%key(list))
        set(n)%name = text%all(key:key + index(text%all(key:), '"') - 2)
      end associate
      text%at = json%at(list)
      call check_new(text, set(:n), error)
      if (allocated(error)) return
      if (json%type(list) /= JSON_LIST) then
        call fail_in_file(text, 'set '//quoted(set(n)%name)//' is not a list', error, &
                          'a set is a list of elements, counted from 0')
        return
      end if
      allocate (set(n)%elem(json%length(list)))
      e = first_of(json, list)
      found = .false.
      do i = 1, size(set(n)%elem)
        call to_integer(text, json, e, set(n)%name, set(n)%elem(i), error)
        if (allocated(error)) return
        set(n)%elem(i) = set(n)%elem(i) + 1 ! numbers start at 1 here
        if (set(n)%elem(i) < 1 .or. set(n)%elem(i) > surface%nelem) then
          text%at = json%at(e)
          call fail_in_file(text, 'set '//quoted(set(n)%name)//' contains element ' &
                            //to_text(set(n)%elem(i) - 1)//', but the surface has elements 0 to ' &
                            //to_text(surface%nelem - 1), error, 'elements are counted from 0')
          return
        end if
        if (found(set(n)%elem(i))) then
          text%at = json%at(e)
          call fail_in_file(text, 'set '//quoted(set(n)%name)//' contains element ' &
                            //to_text(set(n)%elem(i) - 1)//' twice', error, &
                            'name each element of a set once')
          return
        end if
        found(set(n)%elem(i)) = .true.
        e = json%next(e)
      end do
      list = json%next(list)
    end do
    call move_alloc(set, surface%set)
  end subroutine read_sets

  !> Check that the last set has a name of its own, which is not that of a face.
  subroutine check_new(text, set, error)
    type(text_t), intent(in) :: text
    type(spline_set_t), intent(in) :: set(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    associate (name => set(size(set))%name)
      if (any(name == ['1-', '1+', '2-', '2+', '3-', '3+'])) then
        call fail_in_file(text, 'set '//quoted(name)//' has the name of a face', error, &
                          'give it another name; 3- is the whole surface')
        return
      end if
      do i = 1, size(set) - 1
        if (lower(set(i)%name) /= lower(name)) cycle
        call fail_in_file(text, 'sets '//quoted(set(i)%name)//' and '//quoted(name) &
                          //' have the same name, apart from upper and lower case', error, &
                          'give each set a name of its own')
        return
      end do
    end associate
  end subroutine check_new

  !> Check that a spline has the set `name`.
  subroutine check_set(s, spline, name, place, error)
    type(spline_surface_t), intent(in) :: s
    character(*), intent(in) :: spline, name !! as written in the deck
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    character(64), allocatable :: names(:)
    character(:), allocatable :: hint
    integer :: i

    hint = 'the file of the spline has no sets; 3- and ALL name the whole surface'
    if (allocated(s%set)) then
      allocate (names(size(s%set)))
      do i = 1, size(names)
        if (lower(s%set(i)%name) == lower(name)) return
        names(i) = s%set(i)%name
      end do
      if (size(names) > 0) hint = 'nearest known: '//trim(nearest(name, names))
    end if
    call fail(error, DECK_ERROR, 'spline '//quoted(spline)//' has no set '//quoted(name), &
              place, hint)
  end subroutine check_set

  !> Add the sets as groups to the last body of the mesh, which is the body of the surface. Face
  !! `side` of this body lists its element faces block by block, in the order of the elements.
  subroutine put_sets(s, new, iblock, side, mesh)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: new(:)      !! (nnode of the file) number in the body; 0: none
    integer, intent(in) :: iblock(:)   !! (nelem) block of the body with this element
    integer, intent(in) :: side        !! face of the body that is the surface
    type(mesh_t), intent(inout) :: mesh
    integer :: place(s%nelem), b, e, g, i, n
    logical :: on(maxval([0, new]))

    if (.not. allocated(s%set)) return
    n = 0
    do b = 1, maxval(iblock)
      do e = 1, s%nelem
        if (iblock(e) /= b) cycle
        n = n + 1
        place(e) = n
      end do
    end do
    associate (body => mesh%body(size(mesh%body)))
      allocate (body%group(size(s%set)))
      do g = 1, size(s%set)
        associate (group => body%group(g), elem => s%set(g)%elem)
          group%name = s%set(g)%name
          group%face%block = body%face(side)%block(place(elem))
          group%face%elem = body%face(side)%elem(place(elem))
          group%face%side = body%face(side)%side(place(elem))
          on = .false. ! marks the nodes of the body that belong to elements of the set
          do i = 1, size(elem)
            e = elem(i)
            on(new(s%node(s%first(e):s%first(e + 1) - 1))) = .true.
          end do
          group%node = body%node(pack([(i, i=1, size(on))], on))
        end associate
      end do
    end associate
  end subroutine put_sets

end module spline_set
