!> The one list of mesh words: a new word is a reader in a file of its group and a line here.
module word_table
  use input_draft, only: mesh_word_t, mesh_read_i
  use word_block, only: read_block
  use word_contact, only: read_contact
  use word_curve, only: read_curve
  use word_elements, only: read_elements
  use word_material, only: read_material
  use word_mesh, only: read_mesh
  use word_boundary, only: read_fix, read_move, read_pressure
  use word_nodal, only: read_boundary, read_forces, read_displacements, read_load_numbers
  use word_nodes, only: read_coordinates, read_nurbs, read_transform
  use word_npatch, only: read_knots, read_npatch
  use word_patch, only: read_patch
  use word_position, only: read_places, read_planes
  use word_spline, only: read_spline
  use word_settings, only: read_para, read_print, read_tie
  implicit none
  private
  public :: load_mesh_words

  integer, parameter :: ALONE = 0, WORDS = 1, NUMBERS = 2 !! what follows a word

contains

  !> Rows of all words. `records` are the words that stand in a block, for hints.
  subroutine load_mesh_words(table)
    type(mesh_word_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    call add(table, 'COORdinates', NUMBERS, read_coordinates)
    call add(table, 'ELEMents', NUMBERS, read_elements)
    call add(table, 'BLOCk', WORDS, read_block, 'CART BRIC HEXA MATE')
    call add(table, 'BOUNdary', NUMBERS, read_boundary)
    call add(table, 'FORCe', NUMBERS, read_forces)
    call add(table, 'DISPlacement', NUMBERS, read_displacements)
    call add(table, 'FPROportional', NUMBERS, read_load_numbers)
    call add(table, 'EBOUndary', NUMBERS, read_planes, 'GAP')
    call add(table, 'EDISplacement', NUMBERS, read_planes, 'GAP')
    call add(table, 'EFORce', NUMBERS, read_planes, 'GAP')
    call add(table, 'EPROportional', NUMBERS, read_planes, 'GAP')
    call add(table, 'CBOUndary', WORDS, read_places, 'NODE SURF GAP CART')
    call add(table, 'CDISplacement', WORDS, read_places, 'NODE GAP CART')
    call add(table, 'CFORce', WORDS, read_places, 'NODE GAP CART')
    call add(table, 'CSURface', WORDS, read_places, 'NODE SURF GAP CART NORM')
    call add(table, 'TRANsform', NUMBERS, read_transform)
    call add(table, 'TIE', ALONE, read_tie)
    call add(table, 'PARAmeters', WORDS, read_para)
    call add(table, 'PRINt', ALONE, read_print)
    call add(table, 'NOPRint', ALONE, read_print)
    call add(table, 'MATErial', WORDS, read_material, &
             'SOLI ELAS SMAL FINI DISP ENHA DENS BODY NURB')
    call add(table, 'NURBs', NUMBERS, read_nurbs)
    call add(table, 'KNOTs', WORDS, read_knots, 'OPEN')
    call add(table, 'NPATch', WORDS, read_npatch, 'SOLI')
    call add(table, 'PATCh', WORDS, read_patch, &
             'BOX HEMI NPAT FILE ROTA TRAN ELEM KNOT TYPE ENRI QUAD MATE')
    call add(table, 'SPLIne', WORDS, read_spline, 'LAYE CONS QUAD TYPE REVE ROTA TRAN MATE')
    call add(table, 'MESH', WORDS, read_mesh, 'ROTA TRAN SCAL TYPE MATE CONS')
    call add(table, 'FIX', ALONE, read_fix)
    call add(table, 'MOVE', ALONE, read_move)
    call add(table, 'PRESsure', ALONE, read_pressure)
    call add(table, 'CONTact', WORDS, read_contact, 'SURF NORM FRIC COHE BOND DEPT QUAD')
    call add(table, 'CURVe', WORDS, read_curve, 'FORC TORQ DISP CONT STRE ENER MAXI BOOK')
  end subroutine load_mesh_words

  subroutine add(table, name, follows, read, records)
    type(mesh_word_t), allocatable, intent(inout) :: table(:)
    character(*), intent(in) :: name
    integer, intent(in) :: follows
    procedure(mesh_read_i) :: read
    character(*), intent(in), optional :: records
    type(mesh_word_t) :: row

    row%name = name
    row%has_set = follows /= ALONE
    row%has_numbers = follows == NUMBERS
    row%read => read
    if (present(records)) row%records = records
    table = [table, row]
  end subroutine add

end module word_table
