!> Spline surfaces from files: the format is told by the first characters.
module spline_file
  use base_error, only: error_t, place_t
  use base_text, only: quoted
  use patch_text, only: text_t, load_text, complain
  use spline_bext, only: read_bext, BEXT_HEAD
  use spline_iga, only: read_iga
  use spline_json, only: read_bext_json
  use spline_nurbs, only: read_nurbs
  use spline_surface, only: spline_surface_t
  implicit none
  private
  public :: read_spline_file

contains

  !> The surface of a file.
  subroutine read_spline_file(path, name, surface, place, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: name      !! which surface; blank: the only one
    type(spline_surface_t), intent(out) :: surface
    type(place_t), intent(in) :: place    !! the record that asks for the file
    type(error_t), allocatable, intent(out) :: error
    type(text_t) :: text
    integer :: first

    call load_text(path, place, text, error)
    if (allocated(error)) return
    first = max(1, verify(text%all, ' '//achar(9)//achar(10)//achar(13)))
    if (len_trim(name) > 0 .and. index(text%all, '<xml>') == 0) then
      text%at = 0
      call complain(text, 'the file has no named surfaces', error, 'leave '//quoted(name)//' out')
    else if (index(text%all, '<xml>') > 0) then
      call read_nurbs(text, name, surface, error)
    else if (index(text%all, BEXT_HEAD) == 1) then
      call read_bext(text, surface, error)
    else if (index(text%all(first:), '{') == 1) then
      call read_bext_json(text, surface, error)
    else if (is_iga(text)) then
      call read_iga(text, surface, error)
    else
      call complain(text, 'the format is not known', error, 'known formats: BEXT 2.0, as text ' &
                    //'that begins with '//BEXT_HEAD//' or as JSON, .iga, and G+Smo XML')
    end if
  end subroutine read_spline_file

  !> `type`, at the beginning of a line.
  pure logical function is_iga(text)
    type(text_t), intent(in) :: text

    is_iga = index(text%all, 'type ') == 1 .or. index(text%all, achar(10)//'type ') > 0
  end function is_iga

end module spline_file
