!> Bodies from spline files made by others: the format is told by the first line.
module patch_file
  use base_error, only: error_t, place_t
  use base_text, only: quoted
  use nurbs, only: nurbs_t
  use patch_gismo, only: read_gismo
  use patch_mfem, only: read_mfem
  use patch_nurbs, only: check_nurbs
  use patch_text, only: text_t, load_text, complain
  implicit none
  private
  public :: read_patch_file

contains

  !> One tri-variate patch of a file.
  subroutine read_patch_file(path, name, patch, place, error)
    character(*), intent(in) :: path
    character(*), intent(in) :: name      !! which patch; blank: the only one
    type(nurbs_t), intent(out) :: patch
    type(place_t), intent(in) :: place    !! the record that asks for the file
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
      call complain(text, 'the format is not known', error, &
                    "known formats: 'MFEM NURBS mesh v1.0', and G+Smo XML")
    end if
    if (allocated(error)) return
    call check_nurbs(patch, 3, quoted(path), place, error)
  end subroutine read_patch_file

end module patch_file
