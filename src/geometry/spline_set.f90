!> Named sets of elements of a spline surface: a member `sets` of a JSON file, and the groups of the
!! body that a WHERE may name.
module spline_set
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower, nearest
  use format_json, only: json_t, member, first_of, JSON_LIST, JSON_OBJECT, to_integer
  use mesh, only: mesh_t
  use format_text, only: text_t, fail_in_file
  use spline_surface, only: spline_surface_t, spline_set_t
  implicit none
  private
  public :: read_sets, check_set, put_sets

contains

  !> "sets": {"name": [elements from 0], ...}; a file need not have it.
  subroutine read_sets(text, json, surface, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    type(spline_surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(spline_set_t), allocatable :: set(:)
    integer :: i, s, n

    i = member(text, json, 1, 'sets')
    if (i == 0) return
    text%at = json%at(i)
    if (json%type(i) /= JSON_OBJECT) then
      call fail_in_file(text, '"sets" is not what it should be', error, 'it is an object of lists')
      return
    end if
    allocate (set(json%length(i)))
    s = first_of(json, i)
    do n = 1, size(set)
      associate (key => json%key(s))
        set(n)%name = text%all(key:key + index(text%all(key:), '"') - 2)
      end associate
      call read_elements(text, json, s, surface%nelem, set(n), error)
      if (allocated(error)) return
      s = json%next(s)
    end do
    call move_alloc(set, surface%set)
  end subroutine read_sets

  !> Numbers from 0 in the file, from 1 here.
  subroutine read_elements(text, json, list, nelem, set, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: list, nelem
    type(spline_set_t), intent(inout) :: set
    type(error_t), allocatable, intent(out) :: error
    integer :: i, j

    text%at = json%at(list)
    if (json%type(list) /= JSON_LIST) then
      call fail_in_file(text, 'set '//quoted(set%name)//' is not what it should be', error, &
                    'it is a list of elements')
      return
    end if
    allocate (set%elem(json%length(list)))
    j = first_of(json, list)
    do i = 1, size(set%elem)
      call to_integer(text, json, j, set%name, set%elem(i), error)
      if (allocated(error)) return
      set%elem(i) = set%elem(i) + 1
      if (set%elem(i) < 1 .or. set%elem(i) > nelem) then
        text%at = json%at(j)
        call fail_in_file(text, 'set '//quoted(set%name)//' has element ' &
                      //to_text(set%elem(i) - 1)//' of '//to_text(nelem), error, &
                      'elements are counted from 0')
        return
      end if
      j = json%next(j)
    end do
  end subroutine read_elements

  !> A set of that name is there.
  subroutine check_set(s, spline, name, place, error)
    type(spline_surface_t), intent(in) :: s
    character(*), intent(in) :: spline, name !! as written in the deck
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    character(64), allocatable :: names(:)
    character(:), allocatable :: hint
    integer :: i

    hint = 'its file has no sets; a spline surface is its face 3-, or ALL'
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

  !> Groups of the last body of the mesh, which is the surface's. Its faces of one side stand there
  !! block after block, as its elements do.
  subroutine put_sets(s, new, iblock, side, mesh)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: new(:)      !! (nnode of the file) node of the body; 0: none
    integer, intent(in) :: iblock(:)   !! (nelem) which of the body's blocks an element is in
    integer, intent(in) :: side        !! face of the body that the surface is
    type(mesh_t), intent(inout) :: mesh
    integer :: place(s%nelem), b, e, g, n

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
          group%node = body%node(nodes_of(s, new, elem))
        end associate
      end do
    end associate
  end subroutine put_sets

  !> Nodes of the body that functions of some elements have, rising.
  pure function nodes_of(s, new, elem) result(node)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: new(:), elem(:)
    integer, allocatable :: node(:)
    logical :: on(maxval([0, new]))
    integer :: i, e

    on = .false.
    do i = 1, size(elem)
      e = elem(i)
      on(new(s%node(s%first(e):s%first(e + 1) - 1))) = .true.
    end do
    node = pack([(i, i=1, size(on))], on)
  end function nodes_of

end module spline_set
