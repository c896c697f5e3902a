!> Constraint tables that exist next to the files of a mesh, but that no record reads.
!!
!! `post mesh` writes name.con next to name.msh and name.layer if the mesh has hanging nodes. A deck
!! without the CONStraint record runs, but its hanging nodes are not constrained, so the user is
!! warned.
module unread_constraints
  use base_error, only: place_t
  use base_file, only: file_t, inspect, base_name, FILE_REGULAR
  use base_kinds, only: i8
  use base_text, only: quoted
  use model, only: unread_t
  implicit none
  private
  public :: unread_constraints_t, expect_table, note_table, find_unread

  character(*), parameter :: ENDING = '.con'

  !> The tables that were found, and the tables that are used.
  type :: unread_constraints_t
    type(unread_t), allocatable :: found(:)
    integer(i8), allocatable :: used(:, :) !! (2, n) identities of files
  end type unread_constraints_t

contains

  !> Look for a table next to a mesh or layer file.
  subroutine expect_table(tables, path, place)
    type(unread_constraints_t), intent(inout) :: tables
    character(*), intent(in) :: path
    type(place_t), intent(in) :: place !! record that names the file
    type(unread_t), allocatable :: longer(:)
    type(file_t) :: file
    integer :: dot, n

    dot = index(path, '.', back=.true.)
    if (dot <= index(path, '/', back=.true.)) dot = len(path) + 1
    call inspect(path(:dot - 1)//ENDING, file)
    if (file%kind /= FILE_REGULAR) return
    n = 0
    if (allocated(tables%found)) n = size(tables%found)
    allocate (longer(n + 1))
    if (n > 0) longer(:n) = tables%found
    longer(n + 1)%identity = file%identity
    longer(n + 1)%place = place
    longer(n + 1)%text = 'no CONStraint reads '//quoted(base_name(path(:dot - 1))//ENDING) &
                         //', which is next to '//quoted(base_name(path))
    call move_alloc(longer, tables%found)
  end subroutine expect_table

  !> Record the identity of a table that a record of the deck reads.
  subroutine note_table(tables, path)
    type(unread_constraints_t), intent(inout) :: tables
    character(*), intent(in) :: path
    type(file_t) :: file

    call inspect(path, file)
    if (.not. allocated(tables%used)) allocate (tables%used(2, 0))
    tables%used = reshape([tables%used, file%identity], [2, size(tables%used, 2) + 1])
  end subroutine note_table

  !> List the tables that no record reads, each once, with the last file next to which it was found.
  subroutine find_unread(tables, unread)
    type(unread_constraints_t), intent(in) :: tables
    type(unread_t), allocatable, intent(out) :: unread(:)
    logical, allocatable :: keep(:)
    integer :: i, j

    if (.not. allocated(tables%found)) return
    allocate (keep(size(tables%found)), source=.true.)
    do i = 1, size(tables%found)
      do j = i + 1, size(tables%found)
        if (all(tables%found(i)%identity == tables%found(j)%identity)) keep(i) = .false.
      end do
      if (.not. allocated(tables%used)) cycle
      do j = 1, size(tables%used, 2)
        if (all(tables%found(i)%identity == tables%used(:, j))) keep(i) = .false.
      end do
    end do
    unread = tables%found(pack([(i, i=1, size(keep))], keep))
  end subroutine find_unread

end module unread_constraints
