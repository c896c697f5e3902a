!> Checkpoints: `<stem>.restart.h5` holds the last two.
!!
!! A new file is written beside the old one and takes its name when it is whole, so a kill at any
!! moment leaves a complete file. Reals keep their bits. A file is read only by the program version
!! and for the deck and mesh that wrote it.
module restart_file
  use base_kinds, only: i8
  use base_error, only: error_t, fail, SYSTEM_ERROR, DECK_ERROR
  use model, only: model_t, state_t
  use named_values, only: named_values_t
  use hdf5_file, only: hdf5_t, create_file, open_file, close_file, has_object, copy_object, &
                       put_attribute, get_attribute, flush_file
  use base_file, only: replace_file, remove_file, inspect, file_t
  use byte_file, only: take_room
  use restart_state, only: write_state, read_state, write_bag, read_bag
  implicit none
  private
  public :: fingerprint_t, make_fingerprint, write_checkpoint, read_checkpoint, text_hash

  integer(i8), parameter :: MARGIN = 65536 !! bytes for the structure of a copy

  !> Whose checkpoint it is.
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

  !> Write a checkpoint; the one before it is kept beside it.
  subroutine write_checkpoint(path, print, state, bag, error)
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(state_t), intent(in) :: state
    type(named_values_t), intent(in) :: bag
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: second
    type(hdf5_t) :: file

    call create_file(file, path//'.part', error)
    if (.not. allocated(error)) call write_fingerprint(file, print, error)
    if (.not. allocated(error)) call write_state(file, 'last', state, error)
    if (.not. allocated(error)) call write_bag(file, 'last/bag', bag, error)
    if (.not. allocated(error)) call keep_before(file, path, print, state%step, error)
    if (allocated(error)) then
      call close_file(file, second)
    else
      call close_file(file, error)
    end if
    if (.not. allocated(error)) call replace_file(path//'.part', path, error)
    if (allocated(error)) call remove_file(path//'.part')
  end subroutine write_checkpoint

  !> Read the last checkpoint, or the one before it.
  subroutine read_checkpoint(path, print, state, bag, error, before, any_deck)
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(state_t), intent(inout) :: state !! of the model at time 0: gives the sizes
    type(named_values_t), intent(out) :: bag
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: before
    logical, intent(in), optional :: any_deck !! .true.: another deck of the same mesh may have
    !! written it
    type(error_t), allocatable :: second
    type(hdf5_t) :: file
    character(:), allocatable :: group
    logical :: is_there

    inquire (file=path, exist=is_there)
    call open_file(file, path, .false., error)
    if (allocated(error)) then
      if (index(error%message, ''': ') == 0 .and. is_there) call refuse_file(path, error)
      return
    end if
    call check_fingerprint(file, path, print, error, any_deck)
    group = 'last'
    if (present(before)) then
      if (before) group = 'before'
    end if
    if (.not. allocated(error)) then
      if (has_object(file, group)) then
        call read_state(file, group, state, error)
        if (.not. allocated(error)) call read_bag(file, group//'/bag', bag, error)
        if (allocated(error)) call refuse_file(path, error)
      else
        call fail(error, SYSTEM_ERROR, ''''//path//''' holds one checkpoint only')
      end if
    end if
    call close_file(file, second)
  end subroutine read_checkpoint

  subroutine refuse_file(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call fail(error, SYSTEM_ERROR, ''''//path//''' is no restart file, or it is damaged', &
              hint='restart from a file <deck>.restart.h5 of this program')
  end subroutine refuse_file

  !> Copy what was the last checkpoint; one of this very step is replaced, not kept.
  subroutine keep_before(file, path, print, step, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    integer, intent(in) :: step
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: ignored
    type(hdf5_t) :: old
    character(6) :: group
    integer :: old_step(1)
    logical :: is_there

    inquire (file=path, exist=is_there)
    if (.not. is_there) return
    call open_file(old, path, .false., ignored)
    if (allocated(ignored)) return ! not ours: it goes
    call check_fingerprint(old, path, print, ignored)
    if (.not. allocated(ignored)) call get_attribute(old, 'last', 'step', old_step, ignored)
    if (allocated(ignored)) old_step = huge(1)
    if (old_step(1) <= step) then
      group = merge('last  ', 'before', old_step(1) < step)
      if (has_object(old, trim(group))) call copy_group(old, trim(group), file, path, error)
    end if
    call close_file(old, ignored)
  end subroutine keep_before

  !> HDF5 1.10.8 crashes where the disk is full while it copies: there must be room before.
  subroutine copy_group(old, group, file, path, error)
    type(hdf5_t), intent(in) :: old, file
    character(*), intent(in) :: group, path
    type(error_t), allocatable, intent(out) :: error
    type(file_t) :: size_of

    call flush_file(file, error)
    call inspect(path//'.part', size_of) ! one state, as the one to be copied
    if (.not. allocated(error)) call take_room(path//'.part', size_of%size + MARGIN, error)
    if (.not. allocated(error)) call copy_object(old, group, file, 'before', error)
  end subroutine copy_group

  subroutine write_fingerprint(file, print, error)
    type(hdf5_t), intent(in) :: file
    type(fingerprint_t), intent(in) :: print
    type(error_t), allocatable, intent(out) :: error

    call put_attribute(file, '/', 'content', 'bezel restart', error)
    if (.not. allocated(error)) call put_attribute(file, '/', 'version', print%version, error)
    if (.not. allocated(error)) call put_attribute(file, '/', 'deck_hash', print%deck_hash, error)
    if (.not. allocated(error)) call put_attribute(file, '/', 'sizes', print%sizes, error)
  end subroutine write_fingerprint

  subroutine check_fingerprint(file, path, print, error, any_deck)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(fingerprint_t), intent(in) :: print
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: any_deck
    character(:), allocatable :: content, version, deck_hash
    integer :: sizes(4)
    logical :: same_deck

    same_deck = .true.
    if (present(any_deck)) same_deck = .not. any_deck

    call get_attribute(file, '/', 'content', content, error)
    if (.not. allocated(error)) call get_attribute(file, '/', 'version', version, error)
    if (.not. allocated(error)) call get_attribute(file, '/', 'deck_hash', deck_hash, error)
    if (.not. allocated(error)) call get_attribute(file, '/', 'sizes', sizes, error)
    if (allocated(error)) then
      call refuse_file(path, error)
    else if (version /= print%version) then
      call fail(error, DECK_ERROR, ''''//path//''' was written by version '//version// &
                ', this is '//print%version, hint='restart with the version that wrote it')
    else if (same_deck .and. deck_hash /= print%deck_hash) then
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another deck', &
                hint='restart with the deck, the included files and the --set values of that run')
    else if (any(sizes /= print%sizes)) then
      call fail(error, DECK_ERROR, ''''//path//''' belongs to another mesh', &
                hint='restart with the deck, the included files and the --set values of that run')
    end if
  end subroutine check_fingerprint

  !> 16 hexadecimal digits that tell texts apart.
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
