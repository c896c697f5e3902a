!> `.iga` files of spline surfaces: control points, and for each element the extraction coefficients
!! of its functions, row by row.
!!
!! The reader uses `type` (surface or plane), `nodeN`, `elemN`, `node` and `belem`. Sets may follow,
!! and are ignored. `#` starts a comment.
!! Source: files that the T-splines plug-in of Rhino exports
module format_iga
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text, quoted
  use format_text, only: text_t, fail_in_file, next_word, next_integer, next_integers, next_count, &
                         next_reals, words_left
  use spline_surface, only: spline_surface_t, start_surface, add_point, check_sizes, add_element, &
                            finish_surface
  implicit none
  private
  public :: read_iga

contains

  !> Read the file from its first word on.
  subroutine read_iga(text, surface, error)
    type(text_t), intent(inout) :: text
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    integer, allocatable :: node(:)
    real(wp), allocatable :: c(:, :)
    real(wp) :: x(4)
    integer :: a, at, degree(2), i, last, n, nnode, nelem

    text%comment = '#'
    call next_keyword(text, 'type', error)
    if (allocated(error)) return
    call next_word(text, word)
    if (word /= 'surface' .and. word /= 'plane') then
      call fail_in_file(text, 'the file is of type '//quoted(word), error, &
                        'expected ''type surface'' or ''type plane''')
      return
    end if
    call next_keyword(text, 'nodeN', error)
    if (.not. allocated(error)) call next_count(text, 'the number of control points', nnode, error)
    if (.not. allocated(error)) call next_keyword(text, 'elemN', error)
    if (.not. allocated(error)) call next_count(text, 'the number of elements', nelem, error)
    if (allocated(error)) return
    call start_surface(nnode, nelem, surface)
    do i = 1, nnode
      call next_keyword(text, 'node', error)
      if (.not. allocated(error)) call next_reals(text, 'a coordinate or weight', x, error)
      if (.not. allocated(error)) call add_point(text, x, surface, error)
      if (allocated(error)) return
    end do
    do i = 1, nelem
      ! belem nshl p q; control points, numbered from 0; a row of coefficients for each control
      ! point
      call next_keyword(text, 'belem', error)
      if (allocated(error)) return
      at = text%at
      if (words_left(text) /= 3) then
        call fail_in_file(text, 'expected belem with 3 numbers, found ' &
                          //to_text(words_left(text)), error, &
                          '''belem'' is followed by the number of functions and two degrees')
        return
      end if
      call next_integer(text, 'the number of functions', n, error)
      if (.not. allocated(error)) call next_integers(text, 'a degree', degree, error)
      if (.not. allocated(error)) call check_sizes(text, i, degree, n, error)
      if (allocated(error)) return
      node = [(0, a=1, n)]
      call next_integers(text, 'a control point number', node, error)
      if (allocated(error)) return
      c = reshape([real(wp) ::], [n, product(degree + 1)], pad=[0.0_wp])
      do a = 1, n
        call next_reals(text, 'a coefficient', c(a, :), error)
        if (allocated(error)) return
      end do
      last = text%at
      text%at = at
      call add_element(text, degree, node + 1, c, surface, error)
      if (allocated(error)) return
      text%at = last
    end do
    call next_word(text, word)
    if (len(word) == 0 .or. word == 'set') then
      call finish_surface(text, surface, error)
    else ! otherwise further elements would be ignored
      call fail_in_file(text, 'unexpected '//quoted(word)//' after the last element', error, &
                        'the number of elements, elemN, may be too small')
    end if
  end subroutine read_iga

  !> Read a word, which must be `key`.
  subroutine next_keyword(text, key, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: key
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word

    call next_word(text, word)
    if (word == key) return
    if (len(word) == 0) then
      call fail_in_file(text, 'expected '//quoted(key)//', found the end of the file', error, &
                        'counts in the file may be wrong, or the file is truncated')
    else
      call fail_in_file(text, 'expected '//quoted(key)//', found '//quoted(word), error, &
                        'counts of control points, elements or functions may be wrong')
    end if
  end subroutine next_keyword

end module format_iga
