!> Checkpoints: `<stem>.restart.h5` holds the last two checkpoints.
!!
!! A new file is written next to the old one and takes the name of the old one when it is complete.
!! After the first checkpoint, there is thus always a complete file, even if the program is killed.
!! Real numbers keep all their bits. A file is read only by the version of the program that wrote
!! it, and for the same deck and model. The command RESTart also accepts another deck if its model
!! has only other loads, or, with CONStants, other constants of materials and contacts too.
module restart_file
  use base_error, only: error_t, fail, SYSTEM_ERROR, DECK_ERROR
  use base_file, only: file_t, inspect, note_input, replace_file, remove_file, FILE_REGULAR
  use base_hash, only: file_hash, text_hash
  use base_kinds, only: i8
  use base_text, only: to_text
  use byte_file, only: byte_file_t, open_bytes, close_bytes, write_text, take_room
  use hdf5_file, only: hdf5_t, create_file, open_file, close_file, has_object, copy_object, get, &
                       put_attribute, get_attribute, flush_file
  use model, only: model_t, state_t
  use model_hash, only: hash_model, NPART, PART, CONSTANT_PART, LOAD_PART
  use named_values, only: named_values_t
  use restart_archive, only: archive_t, exchange, numbered
  use restart_state, only: exchange_state
  implicit none
  private
  public :: fingerprint_t, make_fingerprint, write_checkpoint, read_checkpoint

  !> This number is increased when the names or the meaning of the stored values change.
  integer, parameter :: FORMAT = 26
  character(*), parameter :: SEAL_MARK = new_line('a')//'bezel checksum '

  !> The version, deck and model to which a checkpoint belongs.
  type :: fingerprint_t
    character(:), allocatable :: version, deck_hash
    integer :: sizes(4) = 0 !! nodes, blocks, elements, equations
    character(16) :: hash(NPART) = '' !! hashes of the parts of the model
  end type fingerprint_t

contains

  subroutine make_fingerprint(version, deck_text, model, print)
    character(*), intent(in) :: version
    character(*), intent(in) :: deck_text !! deck, included files, settings of the command line
    type(model_t), intent(in) :: model
    type(fingerprint_t), intent(out) :: print

    print%version = version
    print%deck_hash = text_hash(deck_text)
    print%sizes = [model%mesh%nnode, size(model%mesh%block), sum(model%mesh%block%nelem), model%neq]
    call hash_model(model, print%hash)
  end subroutine make_fingerprint

  !> Write a checkpoint and keep the previous one.
  subroutine write_checkpoint(path, print, state, values, error)
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(state_t), intent(in) :: state
    type(named_values_t), intent(in) :: values
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: second
    type(archive_t) :: archive
    type(state_t) :: state_copy ! a copy, because an archive may change what it exchanges
    type(named_values_t) :: values_copy
    integer :: i

    call create_file(archive%file, path//'.part', error)
    call put_attribute(archive%file, '/', 'content', 'bezel restart', error)
    call put_attribute(archive%file, '/', 'format', [FORMAT], error)
    call put_attribute(archive%file, '/', 'version', print%version, error)
    call put_attribute(archive%file, '/', 'deck_hash', print%deck_hash, error)
    call put_attribute(archive%file, '/', 'sizes', print%sizes, error)
    do i = 1, NPART
      call put_attribute(archive%file, '/', numbered('hash', i), print%hash(i), error)
    end do
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
    if (.not. allocated(error)) call seal(path//'.part', error)
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
    character(:), allocatable :: differing, group
    integer :: old_step(1)
    logical :: exists

    inquire (file=path, exist=exists)
    if (.not. exists) return
    call open_file(old, path, .false., ignored)
    if (allocated(ignored)) return ! not a checkpoint: the file is replaced
    call check_fingerprint(old, path, print, ignored, differing)
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
  subroutine read_checkpoint(path, print, state, values, error, before, any_deck, constants, &
                             changed)
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(state_t), intent(inout) :: state !! state at time 0 with the sizes of the model
    type(named_values_t), intent(out) :: values
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: before
    logical, intent(in), optional :: any_deck !! accept a checkpoint of another deck with the same
    !! model, whatever its loads
    logical, intent(in), optional :: constants !! with any_deck: accept other constants too
    character(:), allocatable, intent(out), optional :: changed !! which accepted parts differ
    type(error_t), allocatable :: second
    type(archive_t) :: archive
    character(:), allocatable :: group
    character(:), allocatable :: differing
    logical :: exists

    inquire (file=path, exist=exists)
    call check_seal(path, error)
    if (allocated(error)) return
    call open_file(archive%file, path, .false., error)
    if (allocated(error)) then
      if (index(error%message, ''': ') == 0 .and. exists) call refuse_file(path, error)
      return
    end if
    call note_input(path, checkpoint=.true.)
    call check_fingerprint(archive%file, path, print, error, differing, any_deck, constants)
    if (present(changed)) changed = differing
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
        call fail(error, SYSTEM_ERROR, ''''//path//''' contains only one checkpoint')
      end if
    end if
    call close_file(archive%file, second)
  end subroutine read_checkpoint

  subroutine check_fingerprint(file, path, print, error, changed, any_deck, constants)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable, intent(out) :: changed !! parts that differ and are accepted
    logical, intent(in), optional :: any_deck
    logical, intent(in), optional :: constants
    character(*), parameter :: SAME = 'restart with the deck, the files that it reads and the ' &
                               //'--set values of the analysis that wrote it'
    character(*), parameter :: SIZE_OF(4) = ['nodes         ', 'element blocks', &
                                             'elements      ', 'equations     ']
    type(error_t), allocatable :: ignored
    character(:), allocatable :: content, version, deck_hash, hash, differs, accepted
    integer :: format_found(1), i, sizes(4)
    logical :: same_deck, same_constants

    same_deck = .true.
    if (present(any_deck)) same_deck = .not. any_deck
    same_constants = .true.
    if (present(constants)) same_constants = .not. constants
    changed = ''
    call get_attribute(file, '/', 'content', content, error)
    call get_attribute(file, '/', 'version', version, error)
    call get_attribute(file, '/', 'deck_hash', deck_hash, error)
    call get_attribute(file, '/', 'sizes', sizes, error)
    call get_attribute(file, '/', 'format', format_found, ignored)
    if (allocated(ignored)) format_found = 1 ! files of format 1 do not contain the number
    if (allocated(error)) then
      call refuse_file(path, error)
      return
    else if (version /= print%version) then
      call fail(error, DECK_ERROR, ''''//path//''' was written by version '//version// &
                ', but this is '//print%version, hint='restart with the version that wrote it')
      return
    else if (format_found(1) /= FORMAT) then
      call fail(error, DECK_ERROR, ''''//path//''' has checkpoint format ' &
                //to_text(format_found(1))//', expected '//to_text(FORMAT), &
                hint='start again from the deck, or restart with the program that wrote the file')
      return
    else if (same_deck .and. deck_hash /= print%deck_hash) then
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another deck', hint=SAME &
                //'; the command RESTart also continues with changed loads and steps')
      return
    end if
    do i = 1, size(sizes)
      if (sizes(i) == print%sizes(i)) cycle
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another model: it has ' &
                //to_text(sizes(i))//' '//trim(SIZE_OF(i))//', and this model has ' &
                //to_text(print%sizes(i)), hint=SAME)
      return
    end do
    differs = ''
    accepted = ''
    do i = 1, NPART
      call get_attribute(file, '/', numbered('hash', i), hash, error)
      if (allocated(error)) then
        call refuse_file(path, error)
        return
      end if
      if (hash == print%hash(i)) cycle
      if (.not. same_deck .and. (i == LOAD_PART .or. &
                                 (i == CONSTANT_PART .and. .not. same_constants))) then
        accepted = accepted//', '//trim(PART(i))
      else
        differs = differs//', '//trim(PART(i))
      end if
    end do
    if (differs /= '') then
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another model, which differs in ' &
                //differs(3:), hint=SAME)
    else if (accepted /= '') then
      changed = accepted(3:)
    else if (deck_hash /= print%deck_hash) then
      changed = 'only load tables, steps, tolerances or output'
    end if
  end subroutine check_fingerprint

  subroutine refuse_file(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call fail(error, SYSTEM_ERROR, ''''//path//''' is not a restart file, or it is damaged', &
              hint='restart from a file <deck>.restart.h5 of this program')
  end subroutine refuse_file

  !> Append to a complete file the hash of its contents. HDF5 ignores what follows its own data.
  subroutine seal(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: second
    type(byte_file_t) :: bytes
    type(file_t) :: file
    character(16) :: digits

    call inspect(path, file)
    call file_hash(path, file%size, digits, error)
    if (allocated(error)) return
    call open_bytes(bytes, path, .true., error)
    if (allocated(error)) return
    call write_text(bytes, SEAL_MARK//digits//new_line('a'), error)
    call close_bytes(bytes, second)
    if (allocated(second) .and. .not. allocated(error)) call move_alloc(second, error)
  end subroutine seal

  !> Check the hash at the end of a file, because HDF5 may crash if bytes have changed. If another
  !! program has rewritten the file with HDF5, the hash is lost; in that case only the checksums of
  !! the datasets are checked.
  subroutine check_seal(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(len(SEAL_MARK) + 17) :: mark
    character(16) :: digits
    type(file_t) :: file
    integer(i8) :: length
    integer :: unit, status

    call inspect(path, file)
    length = file%size - len(mark)
    if (file%kind /= FILE_REGULAR .or. length < 0) return
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', &
          action='read', iostat=status)
    if (status /= 0) return
    read (unit, pos=length + 1, iostat=status) mark
    close (unit)
    if (status /= 0 .or. index(mark, SEAL_MARK) /= 1) return
    call file_hash(path, length, digits, error)
    if (allocated(error)) return
    if (mark(len(SEAL_MARK) + 1:len(mark) - 1) /= digits) call refuse_file(path, error)
  end subroutine check_seal

end module restart_file
