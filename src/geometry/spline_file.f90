!> Reads spline surfaces and patches from files, whose formats are recognised by their contents.
!!
!! Surfaces: BEXT 2.0 as text or JSON, `.iga`, G+Smo. Trivariate patches: MFEM NURBS, G+Smo.
module spline_file
  use base_error, only: error_t, place_t
  use base_kinds, only: wp
  use base_text, only: quoted
  use bspline, only: extraction
  use format_bext, only: read_bext, BEXT_HEAD
  use format_bext_json, only: read_bext_json
  use format_gismo, only: read_gismo
  use format_iga, only: read_iga
  use format_mfem, only: read_mfem
  use format_text, only: text_t, load_text, fail_in_file
  use nurbs, only: nurbs_t
  use patch_nurbs, only: check_nurbs
  use spline_surface, only: spline_surface_t, start_surface, add_point, add_element, finish_surface
  implicit none
  private
  public :: read_spline_file, read_patch_file

contains

  !> Read a surface from a file.
  subroutine read_spline_file(path, name, surface, place, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: name      !! name of the surface; blank: the only surface
    type(spline_surface_t), intent(out) :: surface
    type(place_t), intent(in) :: place    !! the record that names the file
    type(error_t), allocatable, intent(out) :: error
    type(text_t) :: text
    integer :: first

    call load_text(path, place, text, error)
    if (allocated(error)) return
    first = max(1, verify(text%all, ' '//achar(9)//achar(10)//achar(13)))
    if (len_trim(name) > 0 .and. index(text%all, '<xml>') == 0) then
      text%at = 0
      call fail_in_file(text, 'surfaces of this format have no names', error, &
                        'remove '//quoted(name))
    else if (index(text%all, '<xml>') > 0) then
      call read_gismo_surface(text, name, surface, error)
    else if (index(text%all, BEXT_HEAD) == 1) then
      call read_bext(text, surface, error)
    else if (index(text%all(first:), '{') == 1) then
      call read_bext_json(text, surface, error)
    else if (index(text%all, 'type ') == 1 .or. index(text%all, achar(10)//'type ') > 0) then
      call read_iga(text, surface, error)
    else
      call fail_in_file(text, 'unknown format of a spline surface', error, &
                        'known formats: BEXT 2.0 (as JSON, or as text that begins with ''' &
                        //BEXT_HEAD//'''), .iga and G+Smo XML')
    end if
  end subroutine read_spline_file

  !> Read the surface with the id `name`, or the only surface if the name is blank, and extract it
  !! element by element.
  subroutine read_gismo_surface(text, name, surface, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(nurbs_t) :: patch
    real(wp), allocatable :: c1(:, :, :), c2(:, :, :), c(:, :)
    integer, allocatable :: first1(:), first2(:), node(:)
    integer :: e1, e2, i, j, k, l, p, q

    call read_gismo(text, name, 2, patch, error)
    if (allocated(error)) return
    call check_nurbs(patch, 2, quoted(text%path), text%place, error)
    if (allocated(error)) return
    call extraction(patch%dir(1), c1, first1)
    call extraction(patch%dir(2), c2, first2)
    call start_surface(size(patch%cp, 2)*size(patch%cp, 3), size(first1)*size(first2), surface)
    do j = 1, size(patch%cp, 3)
      do i = 1, size(patch%cp, 2)
        associate (h => patch%cp(:, i, j, 1))
          call add_point(text, [h(:3)/h(4), h(4)], surface, error)
        end associate
        if (allocated(error)) return
      end do
    end do
    p = size(c1, 1)
    q = size(c2, 1)
    allocate (c(p*q, p*q), node(p*q))
    do e2 = 1, size(first2)
      do e1 = 1, size(first1)
        do j = 1, q
          do i = 1, p
            node(i + p*(j - 1)) = first1(e1) + i - 1 + size(patch%cp, 2)*(first2(e2) + j - 2)
            do l = 1, q
              c(i + p*(j - 1), 1 + p*(l - 1):p*l) = [(c1(i, k, e1)*c2(j, l, e2), k=1, p)]
            end do
          end do
        end do
        call add_element(text, [p - 1, q - 1], node, c, surface, error)
        if (allocated(error)) return
      end do
    end do
    call finish_surface(text, surface, error)
  end subroutine read_gismo_surface

  !> Read one trivariate patch from a file.
  subroutine read_patch_file(path, name, patch, place, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: name      !! name of the patch; blank: the only patch
    type(nurbs_t), intent(out) :: patch
    type(place_t), intent(in) :: place    !! the record that names the file
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: MFEM = 'MFEM NURBS mesh v1.0'
    type(text_t) :: text

    call load_text(path, place, text, error)
    if (allocated(error)) return
    if (index(text%all, MFEM) == 1) then
      text%at = len(MFEM) + 1
      call read_mfem(text, name, patch, error)
    else if (index(text%all, '<xml>') > 0) then
      call read_gismo(text, name, 3, patch, error)
    else
      call fail_in_file(text, 'unknown format of a patch', error, &
                        "known formats: 'MFEM NURBS mesh v1.0', and G+Smo XML")
    end if
    if (allocated(error)) return
    call check_nurbs(patch, 3, quoted(path), place, error)
  end subroutine read_patch_file

end module spline_file
