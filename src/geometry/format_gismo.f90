!> G+Smo XML files, of which one geometry is read: a body (TensorNurbs3 or TensorBSpline3) or a
!! surface (TensorNurbs2 or TensorBSpline2).
!!
!! The reader uses the knot vectors with their degrees, the weights and the coefficients, in which
!! the first direction varies fastest. Other geometries of the file and other tags are skipped.
!! Source: the files of G+Smo (gismo/filedata)
module format_gismo
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text, quoted
  use bspline, only: spline_t, nfunction
  use format_text, only: text_t, fail_in_file, next_word, next_reals
  use nurbs, only: nurbs_t, new_nurbs
  implicit none
  private
  public :: read_gismo

contains

  !> Read the geometry that has `ndir` directions and the id `name`. If the name is blank, read the
  !! only geometry with `ndir` directions.
  subroutine read_gismo(text, name, ndir, patch, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    integer, intent(in) :: ndir           !! 3: a body, 2: a surface
    type(nurbs_t), intent(out) :: patch
    type(error_t), allocatable, intent(out) :: error
    type(text_t) :: part
    type(spline_t) :: dir(ndir)
    real(wp), allocatable :: x(:), w(:)
    integer :: d, first, i, last, n, tag

    first = index(text%all, '<!--') ! blank out comments, so that line numbers stay correct
    do while (first > 0)
      last = first + index(text%all(first:), '-->') + 1
      if (last == first + 1) last = len(text%all)
      do i = first, last
        if (text%all(i:i) /= achar(10)) text%all(i:i) = ' '
      end do
      first = index(text%all, '<!--')
    end do
    call find_geometry(text, name, ndir, first, last, error)
    if (allocated(error)) return
    text%all = text%all(:last) ! leave out the next geometry
    text%at = first
    n = 1
    do d = 1, ndir
      call read_knots(text, d, dir(d), error)
      if (allocated(error)) return
      if (nfunction(dir(d)) <= dir(d)%degree .or. nfunction(dir(d)) > len(text%all)/n) then
        call fail_in_file(text, 'direction '//to_text(d)//' has '//to_text(size(dir(d)%knots)) &
                          //' knots, which do not fit its degree '//to_text(dir(d)%degree) &
                          //' and the size of the file', error)
        return
      end if
      n = n*nfunction(dir(d))
    end do
    allocate (x(3*n), w(n), source=1.0_wp)
    text%at = first
    call enter(text, 'weights', tag, part)
    if (tag > 0) then
      call read_all(part, 'weight', w, error)
    else if (index(attribute(text, first, 'type'), 'TensorNurbs') == 1) then
      text%at = first
      call fail_in_file(text, "the geometry is rational (TensorNurbs), but has no tag 'weights'", &
                        error, 'add its weights; a spline without weights has the type ' &
                        //'TensorBSpline'//to_text(ndir))
    end if
    if (allocated(error)) return
    text%at = first
    call enter(text, 'coefs', tag, part)
    if (tag == 0) then
      call fail_in_file(text, 'the geometry has no tag ''coefs''', error)
    else if (attribute(text, tag, 'geoDim') /= '3') then
      call fail_in_file(text, "expected geoDim '3', found " &
                        //quoted(attribute(text, tag, 'geoDim')), error, &
                        'points must have three coordinates')
    else
      call read_all(part, 'coordinate', x, error)
    end if
    if (.not. allocated(error)) call new_nurbs(patch, dir, reshape(x, [3, n]), w)
  end subroutine read_gismo

  !> Find the part of the file, from its first to its last character, that contains the geometry.
  subroutine find_geometry(text, name, ndir, first, last, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    integer, intent(in) :: ndir
    integer, intent(out) :: first, last
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: type, id, found, others, what, plural, hint
    integer :: n, ntaken, length, tag

    found = ''
    ntaken = 0
    others = ''
    n = 0
    first = 0
    tag = 1
    do
      length = index(text%all(tag:), '<Geometry')
      if (length == 0) exit
      tag = tag + length - 1
      type = attribute(text, tag, 'type')
      id = attribute(text, tag, 'id')
      if (type == 'TensorNurbs'//to_text(ndir) .or. type == 'TensorBSpline'//to_text(ndir)) then
        n = n + 1
        found = found//' '//id
        if (id == name) ntaken = ntaken + 1
        if (id == name .or. len_trim(name) == 0) first = tag
      else
        others = others//' '//type
      end if
      tag = tag + 1
    end do
    what = 'body'
    plural = ' bodies'
    if (ndir == 2) then
      what = 'surface'
      plural = ' surfaces'
    end if
    hint = 'a '//what//' is a geometry TensorNurbs'//to_text(ndir)//' or TensorBSpline' &
           //to_text(ndir)
    last = len(text%all)
    text%at = 0
    if (n == 0 .and. len(others) > 0) then
      call fail_in_file(text, 'the file has no '//what//', only geometries of type'//others, &
                        error, hint)
    else if (n == 0) then
      call fail_in_file(text, 'the file has no geometry', error, hint)
    else if (first == 0) then
      call fail_in_file(text, 'the file has no '//what//' '//quoted(trim(name)), error, &
                        'ids of the'//plural//' in the file:'//found)
    else if (ntaken > 1) then
      call fail_in_file(text, 'the file has '//to_text(ntaken)//plural//' with the id ' &
                        //quoted(trim(name)), error, 'give each of them its own id')
    else if (n > 1 .and. len_trim(name) == 0) then
      call fail_in_file(text, 'the file has '//to_text(n)//plural &
                        //', but the deck names none of them', &
                        error, 'name one of them by its id:'//found)
    else
      length = index(text%all(first:), '</Geometry>')
      text%at = first
      if (length == 0) call fail_in_file(text, 'the geometry has no end tag', error, &
                                         'the file seems to be truncated')
      last = first + length - 2
    end if
  end subroutine find_geometry

  !> Value of an attribute of the tag that begins at `tag`; empty if there is no such attribute.
  function attribute(text, tag, name) result(value)
    type(text_t), intent(in) :: text
    integer, intent(in) :: tag
    character(*), intent(in) :: name
    character(:), allocatable :: value
    integer :: first, last, end_of_tag

    value = ''
    end_of_tag = tag + index(text%all(tag:), '>') - 1
    first = index(text%all(tag:end_of_tag), ' '//name//'="')
    if (first == 0) return
    first = tag + first + len(name) + 2
    last = first + index(text%all(first:end_of_tag), '"') - 2
    value = text%all(first:last)
  end function attribute

  !> Find the next tag with a given name, and its content up to the next tag of any name.
  subroutine enter(text, name, tag, part)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    integer, intent(out) :: tag        !! position at which the tag begins; 0: there is none
    type(text_t), intent(out) :: part  !! text up to the end of the content, positioned at its start
    integer :: length

    length = index(text%all(text%at:), '<'//name)
    tag = 0
    if (length == 0) return
    tag = text%at + length - 1
    part = text
    part%at = tag + index(text%all(tag:), '>')
    length = index(text%all(part%at:), '<')
    if (length == 0) length = len(text%all) - part%at + 2
    part%all = text%all(:part%at + length - 2) ! with the text before it, for line numbers
    text%at = part%at
  end subroutine enter

  !> Read numbers, after which this part of the file must end.
  subroutine read_all(part, what, x, error)
    type(text_t), intent(inout) :: part
    character(*), intent(in) :: what   !! one of the numbers
    real(wp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    integer :: n

    n = count_words(part)
    if (n < size(x)) then
      call fail_in_file(part, 'expected '//to_text(size(x))//' '//what//'s, found ' &
                        //to_text(n), error)
      return
    end if
    call next_reals(part, 'a '//what, x, error)
    if (allocated(error)) return
    call next_word(part, word)
    if (len(word) > 0) call fail_in_file(part, 'expected only '//to_text(size(x)) &
                                         //' numbers, found another word: '//quoted(word), error)
  end subroutine read_all

  !> Number of the words that follow.
  integer function count_words(part) result(n)
    type(text_t), intent(in) :: part
    type(text_t) :: rest
    character(:), allocatable :: word

    rest = part
    n = -1
    do
      n = n + 1
      call next_word(rest, word)
      if (len(word) == 0) exit
    end do
  end function count_words

  !> Read the next knot vector.
  subroutine read_knots(text, d, s, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: d
    type(spline_t), intent(out) :: s
    type(error_t), allocatable, intent(out) :: error
    type(text_t) :: part
    character(:), allocatable :: degree
    integer :: tag, status

    call enter(text, 'KnotVector', tag, part)
    if (tag == 0) then
      call fail_in_file(text, 'direction '//to_text(d)//' has no tag ''KnotVector''', error)
      return
    end if
    degree = attribute(text, tag, 'degree')
    status = 1
    if (len(degree) > 0 .and. len(degree) < 4 .and. verify(degree, '0123456789') == 0) then
      read (degree, *, iostat=status) s%degree
    end if
    if (status /= 0) then
      call fail_in_file(text, quoted(degree)//' is not a valid degree for a KnotVector', error)
      return
    end if
    allocate (s%knots(count_words(part)))
    call read_all(part, 'knot', s%knots, error)
  end subroutine read_knots

end module format_gismo
