!> JSON, as much of it as a report needs. Numbers with 17 digits give the same bits back; what is
!! not a finite number is null.
module json_text
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp, i8
  implicit none
  private
  public :: json_string, json_number, json_member, json_object

  interface json_number
    module procedure from_real, from_integer, from_long
  end interface json_number

contains

  !> Text in quotes. Bytes that are not UTF-8 or ASCII control codes are escaped.
  pure function json_string(text) result(json)
    character(*), intent(in) :: text
    character(:), allocatable :: json
    integer :: i, n

    json = '"'
    i = 1
    do while (i <= len(text))
      n = utf8_length(text(i:))
      if (n > 1) then
        json = json//text(i:i + n - 1)
      else
        json = json//escaped(text(i:i), n == 0)
      end if
      i = i + max(n, 1)
    end do
    json = json//'"'
  end function json_string

  !> One byte; `strange`: it is no character of UTF-8, and is read as Latin 1.
  pure function escaped(byte, strange) result(json)
    character(1), intent(in) :: byte
    logical, intent(in) :: strange
    character(:), allocatable :: json
    character(4) :: digits

    select case (iachar(byte))
    case (34, 92)
      json = achar(92)//byte
    case (9)
      json = achar(92)//'t'
    case (10)
      json = achar(92)//'n'
    case (13)
      json = achar(92)//'r'
    case default
      if (strange .or. iachar(byte) < 32 .or. iachar(byte) == 127) then
        write (digits, '(z4.4)') iachar(byte)
        json = achar(92)//'u'//digits
      else
        json = byte
      end if
    end select
  end function escaped

  !> Bytes of the character that begins the text; 0 where they are not UTF-8.
  pure function utf8_length(text) result(n)
    character(*), intent(in) :: text
    integer :: n
    integer :: i, lead

    lead = iachar(text(1:1))
    select case (lead)
    case (:127)
      n = 1
    case (194:223)
      n = 2
    case (224:239)
      n = 3
    case (240:244)
      n = 4
    case default
      n = 0
    end select
    if (n > len(text)) n = 0
    do i = 2, n
      if (iachar(text(i:i)) < 128 .or. iachar(text(i:i)) > 191) then
        n = 0
        return
      end if
    end do
  end function utf8_length

  pure function from_real(x) result(json)
    real(wp), intent(in) :: x
    character(:), allocatable :: json
    character(32) :: field

    if (ieee_is_finite(x)) then
      write (field, '(es24.16e3)') x
      json = trim(adjustl(field))
    else
      json = 'null'
    end if
  end function from_real

  pure function from_integer(i) result(json)
    integer, intent(in) :: i
    character(:), allocatable :: json

    json = from_long(int(i, i8))
  end function from_integer

  pure function from_long(i) result(json)
    integer(i8), intent(in) :: i
    character(:), allocatable :: json
    character(24) :: field

    write (field, '(i0)') i
    json = trim(field)
  end function from_long

  !> `"name": value`
  pure function json_member(name, value) result(json)
    character(*), intent(in) :: name, value
    character(:), allocatable :: json

    json = json_string(name)//': '//value
  end function json_member

  !> Members in braces.
  pure function json_object(members) result(json)
    character(*), intent(in) :: members !! joined by commas
    character(:), allocatable :: json

    json = '{'//members//'}'
  end function json_object

end module json_text
