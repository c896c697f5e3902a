!> Checkpoints: `<stem>.restart.h5` holds the last two.
!!
!! A new file is written next to the old one and takes its name when it is complete, so that a
!! complete file is left whenever the program is killed. Real numbers keep all their bits. A file is
!! read only by the version of the program that wrote it, and for the same deck and mesh.
module restart_file
  use base_error, only: error_t, fail, SYSTEM_ERROR, DECK_ERROR
  use base_file, only: file_t, inspect, note_input, replace_file, remove_file
  use base_kinds, only: i8
  use base_text, only: to_text
  use byte_file, only: take_room
  use hdf5_file, only: hdf5_t, create_file, open_file, close_file, has_object, copy_object, get, &
                       put_attribute, get_attribute, flush_file
  use model, only: model_t, state_t
  use named_values, only: named_values_t
  use restart_archive, only: archive_t, exchange
  use restart_state, only: exchange_state
  implicit none
  private
  public :: fingerprint_t, make_fingerprint, write_checkpoint, read_checkpoint, text_hash

  !> This number is increased when the names or the meaning of the stored values change.
  integer, parameter :: FORMAT = 2

  !> The version, deck and mesh that a checkpoint belongs to.
  type :: fingerprint_t
    character(:), allocatable :: version, deck_hash
    integer :: sizes(4) = 0 !! nodes, blocks, elements, equations
  end type fingerprint_t

contains

  subroutine make_fingerprint(version, deck_text, model, print)
    character(*), intent(in) :: version
    character(*), intent(in) :: deck_text !! with included files and settings of the command line
    type(model_t), intent(in) :: model
    type(fingerprint_t), intent(out) :: print

    print%version = version
    print%deck_hash = text_hash(deck_text)
    print%sizes = [model%mesh%nnode, size(model%mesh%block), sum(model%mesh%block%nelem), model%neq]
  end subroutine make_fingerprint

  !> Write a checkpoint and keep the one before it.
  subroutine write_checkpoint(path, print, state, values, error)
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(state_t), intent(in) :: state
    type(named_values_t), intent(in) :: values
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: second
    type(archive_t) :: archive
    type(state_t) :: state_copy ! a copy, as an archive may change what it exchanges
    type(named_values_t) :: values_copy

    call create_file(archive%file, path//'.part', error)
    call put_attribute(archive%file, '/', 'content', 'bezel restart', error)
    call put_attribute(archive%file, '/', 'format', [FORMAT], error)
    call put_attribute(archive%file, '/', 'version', print%version, error)
    call put_attribute(archive%file, '/', 'deck_hash', print%deck_hash, error)
    call put_attribute(archive%file, '/', 'sizes', print%sizes, error)
    state_copy = state
    values_copy = values
    call exchange_state(archive, 'last', state_copy, error)
    call exchange(archive, 'last/values', values_copy, error)
    if (.not. allocated(error)) call keep_before(archive%file, path, print, state%step, error)
    if (allocated(error)) then
      call close_file(archive%file, second)
    else
      call close_file(archive%file, error)
    end if
    if (.not. allocated(error)) call replace_file(path//'.part', path, error)
    if (allocated(error)) call remove_file(path//'.part')
  end subroutine write_checkpoint

  !> Copy the previous checkpoint. A checkpoint of the same step is replaced, not kept.
  subroutine keep_before(file, path, print, step, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    integer, intent(in) :: step
    type(error_t), allocatable, intent(out) :: error
    integer(i8), parameter :: MARGIN = 65536 !! bytes for the structure of the copy
    type(error_t), allocatable :: ignored
    type(hdf5_t) :: old
    type(file_t) :: written
    character(:), allocatable :: group
    integer :: old_step(1)
    logical :: exists

    inquire (file=path, exist=exists)
    if (.not. exists) return
    call open_file(old, path, .false., ignored)
    if (allocated(ignored)) return ! it is not a checkpoint: it is replaced
    call check_fingerprint(old, path, print, ignored)
    call get(old, 'last/step', old_step, ignored)
    if (allocated(ignored)) old_step = huge(1)
    group = trim(merge('last  ', 'before', old_step(1) < step))
    exists = has_object(old, group)
    if (old_step(1) <= step .and. exists) then
      ! HDF5 1.10.8 crashes if the disk becomes full while it copies, so the space is claimed first.
      ! The file now holds one state, which is as large as the one to be copied.
      call flush_file(file, error)
      call inspect(path//'.part', written)
      if (.not. allocated(error)) call take_room(path//'.part', written%size + MARGIN, error)
      call copy_object(old, group, file, 'before', error)
    end if
    call close_file(old, ignored)
  end subroutine keep_before

  !> Read the last checkpoint, or the one before it.
  subroutine read_checkpoint(path, print, state, values, error, before, any_deck)
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(state_t), intent(inout) :: state !! at time 0, to give the sizes of the model
    type(named_values_t), intent(out) :: values
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: before
    logical, intent(in), optional :: any_deck !! accept a checkpoint of another deck with the same
    !! mesh
    type(error_t), allocatable :: second
    type(archive_t) :: archive
    character(:), allocatable :: group
    logical :: exists

    inquire (file=path, exist=exists)
    call open_file(archive%file, path, .false., error)
    if (allocated(error)) then
      if (index(error%message, ''': ') == 0 .and. exists) call refuse_file(path, error)
      return
    end if
    call note_input(path, checkpoint=.true.)
    call check_fingerprint(archive%file, path, print, error, any_deck)
    group = 'last'
    if (present(before)) then
      if (before) group = 'before'
    end if
    if (.not. allocated(error)) then
      if (has_object(archive%file, group)) then
        archive%writes = .false.
        call exchange_state(archive, group, state, error)
        call exchange(archive, group//'/values', values, error)
        if (allocated(error)) call refuse_file(path, error)
      else
        call fail(error, SYSTEM_ERROR, ''''//path//''' holds only one checkpoint')
      end if
    end if
    call close_file(archive%file, second)
  end subroutine read_checkpoint

  subroutine check_fingerprint(file, path, print, error, any_deck)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: any_deck
    character(*), parameter :: SAME = 'restart with the deck, the included files and the --set ' &
                               //'values of that analysis'
    type(error_t), allocatable :: ignored
    character(:), allocatable :: content, version, deck_hash
    integer :: format_found(1), sizes(4)
    logical :: same_deck

    same_deck = .true.
    if (present(any_deck)) same_deck = .not. any_deck
    call get_attribute(file, '/', 'content', content, error)
    call get_attribute(file, '/', 'version', version, error)
    call get_attribute(file, '/', 'deck_hash', deck_hash, error)
    call get_attribute(file, '/', 'sizes', sizes, error)
    call get_attribute(file, '/', 'format', format_found, ignored)
    if (allocated(ignored)) format_found = 1 ! files of format 1 do not contain the number
    if (allocated(error)) then
      call refuse_file(path, error)
    else if (version /= print%version) then
      call fail(error, DECK_ERROR, ''''//path//''' was written by version '//version// &
                ', but this is '//print%version, hint='restart with the version that wrote it')
    else if (format_found(1) /= FORMAT) then
      call fail(error, DECK_ERROR, ''''//path//''' has checkpoint format ' &
                //to_text(format_found(1))//', expected '//to_text(FORMAT), &
                hint='start again from the deck, or restart with the program that wrote the file')
    else if (same_deck .and. deck_hash /= print%deck_hash) then
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another deck', hint=SAME)
    else if (any(sizes /= print%sizes)) then
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another mesh', hint=SAME)
    end if
  end subroutine check_fingerprint

  subroutine refuse_file(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call fail(error, SYSTEM_ERROR, ''''//path//''' is not a restart file, or it is damaged', &
              hint='restart from a file <deck>.restart.h5 of this program')
  end subroutine refuse_file

  !> 16 hexadecimal digits that distinguish texts.
  pure function text_hash(text) result(digits)
    character(*), intent(in) :: text
    character(16) :: digits
    integer(i8) :: h(2)
    integer :: i

    h = [7_i8, 11_i8]
    do i = 1, len(text)
      h(1) = modulo(h(1)*131_i8 + iachar(text(i:i)) + 1, 2147483647_i8)
      h(2) = modulo(h(2)*257_i8 + iachar(text(i:i)) + 1, 2147483629_i8)
    end do
    write (digits, '(2z8.8)') h
  end function text_hash

end module restart_file
