!> Tables of constraints that stand beside the files of a mesh and that no record reads.
!!
!! `post mesh` writes name.con beside name.msh and name.layer where nodes hang. A deck without its
!! CONStraint runs, but those nodes are free.
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

  !> Files that a table may stand beside, and the tables that were read.
  type :: unread_constraints_t
    type(unread_t), allocatable :: near(:)
    integer(i8), allocatable :: known(:, :) !! (2, n) identities of files
  end type unread_constraints_t

contains

  !> A file of a mesh or of a layer: there may be a table beside it.
  subroutine expect_table(aside, path, place)
    type(unread_constraints_t), intent(inout) :: aside
    character(*), intent(in) :: path
    type(place_t), intent(in) :: place
    type(unread_t) :: one
    type(unread_t), allocatable :: longer(:)
    type(file_t) :: file
    integer :: dot, n

    dot = index(path, '.', back=.true.)
    if (dot <= index(path, '/', back=.true.)) dot = len(path) + 1
    call inspect(path(:dot - 1)//ENDING, file)
    if (file%kind /= FILE_REGULAR) return
    one%identity = file%identity
    one%place = place
    one%text = quoted(base_name(path(:dot - 1))//ENDING)//' stands beside ' &
               //quoted(base_name(path))//', and no CONStraint reads it'
    n = 0
    if (allocated(aside%near)) n = size(aside%near)
    allocate (longer(n + 1))
    if (n > 0) longer(:n) = aside%near
    longer(n + 1) = one
    call move_alloc(longer, aside%near)
  end subroutine expect_table

  !> A table that a record reads.
  subroutine note_table(aside, path)
    type(unread_constraints_t), intent(inout) :: aside
    character(*), intent(in) :: path
    type(file_t) :: file

    call inspect(path, file)
    if (.not. allocated(aside%known)) allocate (aside%known(2, 0))
    aside%known = reshape([aside%known, file%identity], [2, size(aside%known, 2) + 1])
  end subroutine note_table

  !> Tables that nobody read, each once, at the last file that it stands beside.
  subroutine find_unread(aside, unread)
    type(unread_constraints_t), intent(in) :: aside
    type(unread_t), allocatable, intent(out) :: unread(:)
    logical, allocatable :: keep(:)
    integer :: i, j, n

    if (.not. allocated(aside%near)) return
    allocate (keep(size(aside%near)), source=.true.)
    do i = 1, size(aside%near)
      do j = i + 1, size(aside%near)
        if (all(aside%near(i)%identity == aside%near(j)%identity)) keep(i) = .false.
      end do
      if (.not. allocated(aside%known)) cycle
      do j = 1, size(aside%known, 2)
        if (all(aside%near(i)%identity == aside%known(:, j))) keep(i) = .false.
      end do
    end do
    allocate (unread(count(keep)))
    n = 0
    do i = 1, size(keep)
      if (.not. keep(i)) cycle
      n = n + 1
      unread(n) = aside%near(i)
    end do
  end subroutine find_unread

end module unread_constraints
