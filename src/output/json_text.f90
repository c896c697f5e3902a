!> Writes the part of JSON that a report needs. Real numbers have 17 digits, so that reading them
!! restores the same bits. A number that is not finite becomes null.
module json_text
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use base_text, only: to_text
  implicit none
  private
  public :: json_string, json_number, json_member, json_object

  interface json_number
    module procedure from_real, from_integer
  end interface json_number

contains

  !> Text in quotes. Quotes, backslashes and control codes are escaped. Bytes that are not UTF-8 are
  !! read as Latin 1 and are escaped too.
  pure function json_string(text) result(json)
    character(*), intent(in) :: text
    character(:), allocatable :: json
    character(4) :: digits
    integer :: i, n

    json = '"'
    i = 1
    do while (i <= len(text))
      n = utf8_length(text(i:))
      if (n > 1) then
        json = json//text(i:i + n - 1)
      else
        select case (iachar(text(i:i)))
        case (34, 92)
          json = json//achar(92)//text(i:i)
        case (9)
          json = json//achar(92)//'t'
        case (10)
          json = json//achar(92)//'n'
        case (13)
          json = json//achar(92)//'r'
        case default
          if (n == 0 .or. iachar(text(i:i)) < 32 .or. iachar(text(i:i)) == 127) then
            write (digits, '(z4.4)') iachar(text(i:i))
            json = json//achar(92)//'u'//digits
          else
            json = json//text(i:i)
          end if
        end select
      end if
      i = i + max(n, 1)
    end do
    json = json//'"'
  end function json_string

  !> Number of bytes of the first character of the text; 0 if they are not UTF-8.
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

    json = to_text(i)
  end function from_integer

  !> A member `"name": value`.
  pure function json_member(name, value) result(json)
    character(*), intent(in) :: name, value
    character(:), allocatable :: json

    json = json_string(name)//': '//value
  end function json_member

  !> An object: its members in braces.
  pure function json_object(members) result(json)
    character(*), intent(in) :: members !! joined by commas
    character(:), allocatable :: json

    json = '{'//members//'}'
  end function json_object

end module json_text
