!> The files of a deck in memory, each once.
module deck_source_list
  use base_error, only: error_t, place_t
  use base_file, only: file_t, base_name, FILE_ABSENT
  use deck_source, only: source_t, load_source
  implicit none
  private
  public :: source_list_t, find_source, add_source, joined

  type :: source_list_t
    integer :: n = 0
    type(source_t), allocatable :: item(:) !! (>= n)
  end type source_list_t

contains

  !> Position of a file in the list; 0: it is new.
  pure integer function find_source(list, file) result(at)
    type(source_list_t), intent(in) :: list
    type(file_t), intent(in) :: file

    at = 0
    if (file%kind == FILE_ABSENT) return
    do at = list%n, 1, -1
      if (all(list%item(at)%identity == file%identity)) return
    end do
  end function find_source

  !> Read a file into the list.
  subroutine add_source(list, path, at, error, place)
    type(source_list_t), intent(inout) :: list
    character(*), intent(in) :: path
    integer, intent(out) :: at                    !! its position
    type(error_t), allocatable, intent(out) :: error
    type(place_t), intent(in), optional :: place  !! of the record that asked for it

    call make_room(list)
    at = list%n + 1
    call load_source(path, list%item(at), error, place)
    if (.not. allocated(error)) list%n = at
  end subroutine add_source

  !> For one file more; the texts move, nothing is copied.
  subroutine make_room(list)
    type(source_list_t), intent(inout) :: list
    type(source_t), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list%item)) allocate (list%item(4))
    if (list%n < size(list%item)) return
    allocate (longer(2*list%n))
    do i = 1, list%n
      call move_source(list%item(i), longer(i))
    end do
    call move_alloc(longer, list%item)
  end subroutine make_room

  subroutine move_source(from, to)
    type(source_t), intent(inout) :: from
    type(source_t), intent(inout) :: to

    to%identity = from%identity
    to%nline = from%nline
    call move_alloc(from%path, to%path)
    call move_alloc(from%text, to%text)
    call move_alloc(from%first, to%first)
    call move_alloc(from%last, to%last)
  end subroutine move_source

  !> All files as they were read, one behind the other.
  pure function joined(list) result(text)
    type(source_list_t), intent(in) :: list
    character(:), allocatable :: text
    integer :: i

    text = list%item(1)%text
    do i = 2, list%n
      text = text//new_line('a')//'! --- '//base_name(list%item(i)%path)//new_line('a') &
             //list%item(i)%text
    end do
  end function joined

end module deck_source_list
