!> The table of mesh words: a new word needs a reader in the file of its group and a line here.
module word_table
  use base_text, only: key_of
  use input_draft, only: mesh_word_t, mesh_read_i
  use word_block, only: read_block, BLOCK_RECORDS
  use word_boundary, only: read_fix, read_move, read_pressure
  use word_contact, only: read_contact, CONTACT_RECORDS
  use word_curve, only: read_curve, CURVE_RECORDS
  use word_elements, only: read_elements
  use word_material, only: read_material, MATERIAL_RECORDS => WORD
  use word_mesh, only: read_mesh, MESH_RECORDS
  use word_nodal, only: read_boundary, read_load_numbers, read_vectors
  use word_nodes, only: read_points, read_transform
  use word_npatch, only: read_knots, read_npatch, KNOT_RECORDS, NPATCH_RECORDS
  use word_patch, only: read_patch, PATCH_RECORDS
  use word_position, only: read_places, read_planes, PLANE_RECORDS, POINT_RECORDS, CBOU_RECORDS, &
                           CSUR_RECORDS
  use word_settings, only: read_para, read_print, read_tie
  use word_spline, only: read_spline, SPLINE_RECORDS
  implicit none
  private
  public :: load_mesh_words

  integer, parameter :: ALONE = 0, WORDS = 1, NUMBERS = 2 !! the data that follow a word

contains

  !> Load the rows of all words, with the words of their records.
  subroutine load_mesh_words(table)
    type(mesh_word_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    call add(table, 'COORdinates', NUMBERS, read_points)
    call add(table, 'ELEMents', NUMBERS, read_elements)
    call add(table, 'BLOCk', WORDS, read_block, BLOCK_RECORDS)
    call add(table, 'BOUNdary', NUMBERS, read_boundary)
    call add(table, 'FORCe', NUMBERS, read_vectors)
    call add(table, 'DISPlacement', NUMBERS, read_vectors)
    call add(table, 'FPROportional', NUMBERS, read_load_numbers)
    call add(table, 'EBOUndary', NUMBERS, read_planes, PLANE_RECORDS)
    call add(table, 'EDISplacement', NUMBERS, read_planes, PLANE_RECORDS)
    call add(table, 'EFORce', NUMBERS, read_planes, PLANE_RECORDS)
    call add(table, 'EPROportional', NUMBERS, read_planes, PLANE_RECORDS)
    call add(table, 'CBOUndary', WORDS, read_places, CBOU_RECORDS)
    call add(table, 'CDISplacement', WORDS, read_places, POINT_RECORDS)
    call add(table, 'CFORce', WORDS, read_places, POINT_RECORDS)
    call add(table, 'CSURface', WORDS, read_places, CSUR_RECORDS)
    call add(table, 'TRANsform', NUMBERS, read_transform)
    call add(table, 'TIE', ALONE, read_tie)
    call add(table, 'PARAmeters', WORDS, read_para)
    call add(table, 'PRINt', ALONE, read_print)
    call add(table, 'NOPRint', ALONE, read_print)
    call add(table, 'MATErial', WORDS, read_material, ['SOLId       ', MATERIAL_RECORDS])
    call add(table, 'NURBs', NUMBERS, read_points)
    call add(table, 'KNOTs', WORDS, read_knots, KNOT_RECORDS)
    call add(table, 'NPATch', WORDS, read_npatch, NPATCH_RECORDS)
    call add(table, 'PATCh', WORDS, read_patch, PATCH_RECORDS%name)
    call add(table, 'SPLIne', WORDS, read_spline, SPLINE_RECORDS%name)
    call add(table, 'MESH', WORDS, read_mesh, MESH_RECORDS%name)
    call add(table, 'FIX', ALONE, read_fix)
    call add(table, 'MOVE', ALONE, read_move)
    call add(table, 'PRESsure', ALONE, read_pressure)
    call add(table, 'CONTact', WORDS, read_contact, CONTACT_RECORDS%name)
    call add(table, 'CURVe', WORDS, read_curve, CURVE_RECORDS%name)
  end subroutine load_mesh_words

  !> Append a row.
  subroutine add(table, name, follows, read, records)
    type(mesh_word_t), allocatable, intent(inout) :: table(:)
    character(*), intent(in) :: name
    integer, intent(in) :: follows
    procedure(mesh_read_i) :: read
    character(*), intent(in), optional :: records(:)
    type(mesh_word_t) :: row
    integer :: i

    row%name = name
    row%has_set = follows /= ALONE
    row%has_numbers = follows == NUMBERS
    row%read => read
    if (present(records)) then
      do i = 1, size(records)
        row%records(i) = key_of(records(i))
      end do
    end if
    table = [table, row]
  end subroutine add

end module word_table
