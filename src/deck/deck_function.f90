!> The functions that an expression may call. Functions whose names end in d take or return degrees;
!! sind, cosd and tand give exact values such as cosd(60) = 1/2 and cosd(90) = 0.
module deck_function
  use base_kinds, only: wp
  use base_text, only: to_text
  implicit none
  private
  public :: apply_function, function_index, function_names

  integer, parameter :: MANY = huge(1)
  character(5), parameter :: NAMES(20) = &
                             ['sin  ', 'cos  ', 'tan  ', 'asin ', 'acos ', 'atan ', 'sind ', &
                              'cosd ', 'tand ', 'asind', 'acosd', 'atand', 'sqrt ', 'exp  ', &
                              'log  ', 'abs  ', 'int  ', 'min  ', 'max  ', 'atan2']
  real(wp), parameter, public :: PI = acos(-1.0_wp)

contains

  !> Names of all functions, for hints.
  function function_names() result(list)
    character(5) :: list(size(NAMES))

    list = NAMES
  end function function_names

  !> Position of a name, which must be in lower case, in the list; 0 if the name is unknown.
  pure function function_index(name) result(f)
    character(*), intent(in) :: name
    integer :: f

    do f = size(NAMES), 1, -1
      if (NAMES(f) == name) return
    end do
  end function function_index

  !> Evaluate function f; `trouble` says why it has no value. The caller has switched floating-point
  !! traps off.
  pure subroutine apply_function(f, x, value, trouble)
    integer, intent(in) :: f
    real(wp), intent(in) :: x(:) !! arguments
    real(wp), intent(out) :: value
    character(:), allocatable, intent(out) :: trouble
    integer :: least, most

    value = 0.0_wp
    least = merge(2, 1, any(NAMES(f) == ['min  ', 'max  ', 'atan2']))
    most = merge(MANY, least, any(NAMES(f) == ['min  ', 'max  ']))
    if (size(x) < least .or. size(x) > most) then
      trouble = "'"//trim(NAMES(f))//"' takes "//to_text(least)//merge(' or more', '        ', &
                                                                       most == MANY)
      trouble = trim(trouble)//' argument'//trim(merge('s', ' ', least > 1 .or. most == MANY)) &
                //', found '//to_text(size(x))
      return
    end if
    call check_domain(f, x, trouble)
    if (allocated(trouble)) return
    select case (trim(NAMES(f)))
    case ('sin'); value = sin(x(1))
    case ('cos'); value = cos(x(1))
    case ('tan'); value = tan(x(1))
    case ('asin'); value = asin(x(1))
    case ('acos'); value = acos(x(1))
    case ('atan'); value = atan(x(1))
    case ('sind'); value = sine_of_degrees(x(1))
    case ('cosd'); value = cosine_of_degrees(x(1))
    case ('tand'); value = sine_of_degrees(x(1))/cosine_of_degrees(x(1))
    case ('asind'); value = asin(x(1))*180/PI
    case ('acosd'); value = acos(x(1))*180/PI
    case ('atand'); value = atan(x(1))*180/PI
    case ('sqrt'); value = sqrt(x(1))
    case ('exp'); value = exp(x(1))
    case ('log'); value = log(x(1))
    case ('abs'); value = abs(x(1))
    case ('int'); value = aint(x(1))
    case ('min'); value = minval(x)
    case ('max'); value = maxval(x)
    case ('atan2'); value = atan2(x(1), x(2))
    case default; trouble = 'unknown function'
    end select
  end subroutine apply_function

  !> Check whether the function has a value for these arguments.
  pure subroutine check_domain(f, x, trouble)
    integer, intent(in) :: f
    real(wp), intent(in) :: x(:)
    character(:), allocatable, intent(out) :: trouble

    select case (trim(NAMES(f)))
    case ('sqrt')
      if (x(1) < 0.0_wp) trouble = 'sqrt needs a non-negative number, found '//to_text(x(1))
    case ('log')
      if (.not. x(1) > 0.0_wp) trouble = 'log needs a positive number, found '//to_text(x(1))
    case ('asin', 'acos', 'asind', 'acosd')
      if (abs(x(1)) > 1.0_wp) trouble = trim(NAMES(f))//' needs a number from -1 to 1, found ' &
                                        //to_text(x(1))
    case ('tand')
      if (.not. abs(cosine_of_degrees(x(1))) > 0.0_wp) trouble = 'tand has no value at ' &
                                                                 //to_text(x(1))
    case ('atan2')
      if (.not. any(abs(x) > 0.0_wp)) trouble = 'atan2 has no value at 0, 0'
    case default
      continue  ! the others have a value everywhere
    end select
  end subroutine check_domain

  pure function sine_of_degrees(x) result(s)
    real(wp), intent(in) :: x
    real(wp) :: s, a

    a = mod(abs(x), 360.0_wp)
    s = sign(1.0_wp, x)
    if (a >= 180.0_wp) then
      a = a - 180.0_wp
      s = -s
    end if
    s = s*first_half(a)
  end function sine_of_degrees

  pure function cosine_of_degrees(x) result(c)
    real(wp), intent(in) :: x
    real(wp) :: c, a

    a = mod(abs(x), 360.0_wp)
    if (a > 180.0_wp) a = 360.0_wp - a
    if (a <= 90.0_wp) then
      c = first_half(90.0_wp - a)
      if (a < 45.0_wp) c = cos(a*(PI/180))
    else
      c = -first_half(a - 90.0_wp)
      if (a > 135.0_wp) c = -cos((180.0_wp - a)*(PI/180))
    end if
  end function cosine_of_degrees

  !> Sine of an angle from 0 to 180 degrees.
  pure function first_half(angle) result(s)
    real(wp), intent(in) :: angle
    real(wp) :: s, a

    a = min(angle, 180.0_wp - angle)
    if (abs(a - 30.0_wp) <= 0.0_wp) then
      s = 0.5_wp
    else if (a <= 45.0_wp) then
      s = sin(a*(PI/180))
    else
      s = cos((90.0_wp - a)*(PI/180))
    end if
  end function first_half

end module deck_function
