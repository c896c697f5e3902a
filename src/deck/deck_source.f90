!> Text files in memory, divided into lines.
module deck_source
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_file, only: file_t, inspect, note_input, base_name, FILE_ABSENT, FILE_REGULAR, &
                       FILE_FOLDER
  use base_kinds, only: i8
  use base_text, only: to_text
  implicit none
  private
  public :: source_t, source_of_text, source_line, source_list_t, find_source, add_source, joined

  integer(i8), parameter :: LARGEST = 2_i8**30 !! largest size of a file, in bytes

  type :: source_t
    character(:), allocatable :: path      !! as messages show it
    character(:), allocatable :: text      !! the whole file
    integer(i8) :: identity(2) = 0         !! device and inode
    integer :: nline = 0
    integer, allocatable :: first(:), last(:) !! (nline) characters of each line, without its end
  end type source_t

  type :: entry_t
    type(source_t), allocatable :: file
  end type entry_t

  !> The files of a deck in memory; each is stored once.
  type :: source_list_t
    integer :: n = 0
    type(entry_t), allocatable :: item(:) !! (>= n)
  end type source_list_t

contains

  !> Read a file, which must be a regular text file; `place` is the place of the record that names
  !! it.
  subroutine load_source(path, source, error, place)
    character(*), intent(in) :: path
    type(source_t), intent(out) :: source
    type(error_t), allocatable, intent(out) :: error
    type(place_t), intent(in), optional :: place
    type(file_t) :: file
    character(200) :: message
    integer :: unit, io

    call inspect(path, file)
    select case (file%kind)
    case (FILE_REGULAR)
      if (file%size == 0) call refuse('is empty')
      if (file%size > LARGEST) call refuse('is larger than '//to_text(LARGEST/1024**2)//' MiB')
    case (FILE_FOLDER)
      call refuse('is a folder')
    case (FILE_ABSENT)
      call refuse('cannot be read: '//file%reason)
    case default
      call refuse('is not a regular file')
    end select
    if (allocated(error)) return
    call note_input(path)
    source%path = path
    source%identity = file%identity
    allocate (character(file%size) :: source%text)
    open (newunit=unit, file=path, status='old', action='read', access='stream', &
          form='unformatted', iostat=io, iomsg=message)
    if (io == 0) then
      read (unit, iostat=io, iomsg=message) source%text
      close (unit)
    end if
    if (io /= 0) then
      call refuse('cannot be read: '//trim(message(index(message, ': ', back=.true.) + 1:)))
    else if (is_binary(source%text)) then
      call refuse('is not a text file', 'a deck is plain text: ASCII or UTF-8')
    else
      call find_lines(source)
    end if

  contains

    subroutine refuse(what, hint)
      character(*), intent(in) :: what
      character(*), intent(in), optional :: hint

      call fail(error, DECK_ERROR, "'"//path//"' "//what, place, hint)
    end subroutine refuse

  end subroutine load_source

  !> Store a text as if it had been read from a file.
  subroutine source_of_text(path, text, source)
    character(*), intent(in) :: path, text
    type(source_t), intent(out) :: source

    source%path = path
    source%text = text
    call find_lines(source)
  end subroutine source_of_text

  !> A line as it is in the file.
  pure function source_line(source, line) result(text)
    type(source_t), intent(in) :: source
    integer, intent(in) :: line
    character(:), allocatable :: text

    text = ''
    if (line < 1 .or. line > source%nline) return
    text = source%text(source%first(line):source%last(line))
  end function source_line

  !> Does the text contain NUL characters, or is more than one character in fifty a control
  !! character?
  pure function is_binary(text) result(yes)
    character(*), intent(in) :: text
    logical :: yes
    integer :: i, c
    integer(i8) :: strange

    strange = 0
    yes = .true.
    do i = 1, len(text)
      c = iachar(text(i:i))
      if (c == 0) return
      if (c < 9 .or. (c > 13 .and. c < 32) .or. c == 127) strange = strange + 1
    end do
    yes = 50*strange > len(text)
  end function is_binary

  !> Find the lines, which end with LF, CR LF or CR. A byte order mark of UTF-8 at the start is
  !! skipped.
  subroutine find_lines(source)
    type(source_t), intent(inout) :: source
    character, parameter :: LF = achar(10), CR = achar(13)
    integer :: i, n, at, pass

    do pass = 1, 2
      n = 0
      at = 1
      if (index(source%text(:min(3, len(source%text))), char(239)//char(187) &
                //char(191)) == 1) at = 4
      do while (at <= len(source%text))
        i = at
        do while (i <= len(source%text))
          if (source%text(i:i) == LF .or. source%text(i:i) == CR) exit
          i = i + 1
        end do
        n = n + 1
        if (pass == 2) then
          source%first(n) = at
          source%last(n) = i - 1
        end if
        at = i + 1
        if (at <= len(source%text)) then
          if (source%text(i:i) == CR .and. source%text(at:at) == LF) at = at + 1
        end if
      end do
      if (pass == 1) allocate (source%first(n), source%last(n))
    end do
    source%nline = n
  end subroutine find_lines

  !> Position of a file in the list; 0 if the file is not in it.
  pure integer function find_source(list, file) result(at)
    type(source_list_t), intent(in) :: list
    type(file_t), intent(in) :: file

    at = 0
    if (file%kind == FILE_ABSENT) return
    do at = list%n, 1, -1
      if (all(list%item(at)%file%identity == file%identity)) return
    end do
  end function find_source

  !> Read a file and add it to the list.
  subroutine add_source(list, path, at, error, place)
    type(source_list_t), intent(inout) :: list
    character(*), intent(in) :: path
    integer, intent(out) :: at                    !! position in the list
    type(error_t), allocatable, intent(out) :: error
    type(place_t), intent(in), optional :: place  !! place of the record that names it

    type(entry_t), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list%item)) allocate (list%item(4))
    if (list%n == size(list%item)) then
      allocate (longer(2*list%n))
      do i = 1, list%n ! the texts are moved, not copied
        call move_alloc(list%item(i)%file, longer(i)%file)
      end do
      call move_alloc(longer, list%item)
    end if
    at = list%n + 1
    allocate (list%item(at)%file)
    call load_source(path, list%item(at)%file, error, place)
    if (allocated(error)) then
      deallocate (list%item(at)%file)
    else
      list%n = at
    end if
  end subroutine add_source

  !> Text of all files as they were read, one after another.
  pure function joined(list) result(text)
    type(source_list_t), intent(in) :: list
    character(:), allocatable :: text
    integer :: i

    text = list%item(1)%file%text
    do i = 2, list%n
      text = text//new_line('a')//'! --- '//base_name(list%item(i)%file%path)//new_line('a') &
             //list%item(i)%file%text
    end do
  end function joined

end module deck_source
