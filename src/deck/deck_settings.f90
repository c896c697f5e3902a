!> Parameters that the command line sets: --set name=value.
module deck_settings
  use base_error, only: error_t, fail, place_t, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: lower, nearest, quoted, to_text
  use deck_expression, only: compute, params_t, trouble_t
  use deck_params, only: is_name, parameter_names
  implicit none
  private
  public :: setting_t, read_settings, use_setting, check_used, settings_text

  type :: setting_t
    character(:), allocatable :: name !! lower case
    real(wp) :: value = 0.0_wp
    logical :: used = .false.         !! the deck sets the parameter too
    type(place_t) :: place            !! the first record of the deck that sets it
  end type setting_t

contains

  !> Read the settings of the command line in order. A value is an expression without parameters.
  subroutine read_settings(list, settings, error)
    type(setting_t), allocatable, intent(out) :: list(:)
    character(*), intent(in) :: settings(:) !! name=value, as given by --set
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t), allocatable :: trouble
    type(params_t) :: none
    character(:), allocatable :: text, name
    integer :: i, equal

    allocate (list(size(settings)))
    do i = 1, size(settings)
      text = trim(settings(i))
      equal = index(text, '=')
      name = lower(trim(adjustl(text(:max(equal - 1, 0)))))
      if (.not. is_name(name)) then
        call fail(error, DECK_ERROR, quoted('--set '//text)//' does not set a parameter', &
                  hint='write --set name=value')
      else if (position(list(:i - 1), name) > 0) then
        call fail(error, DECK_ERROR, 'duplicate --set of parameter '//quoted(name), &
                  hint='keep one --set '//name//'=value')
      end if
      if (allocated(error)) return
      list(i)%name = name
      call compute(none, text(equal + 1:), list(i)%value, trouble)
      if (.not. allocated(trouble)) cycle
      call fail(error, DECK_ERROR, 'in '//quoted('--set '//text)//': '//trouble%message, &
                hint='write --set name=value, where the value is a number or an expression ' &
                //'without parameters')
      return
    end do
  end subroutine read_settings

  !> Position of a parameter in the list; 0 if the command line does not set it.
  pure integer function position(list, name) result(i)
    type(setting_t), intent(in) :: list(:)
    character(*), intent(in) :: name

    do i = size(list), 1, -1
      if (list(i)%name == name) return
    end do
  end function position

  !> Get the value that the command line gives to a parameter of the deck. It replaces only the
  !! value of the first record that sets the parameter, whenever this record is read: a LOOP of the
  !! mesh part, or a file that is included twice, reads it again. Later records take effect, and so
  !! does the first one if it counts: it then starts from the value of the command line.
  subroutine use_setting(list, name, place, counts, value, found)
    type(setting_t), intent(inout) :: list(:)
    character(*), intent(in) :: name
    type(place_t), intent(in) :: place !! of the record
    logical, intent(in) :: counts      !! its expression contains the parameter itself
    real(wp), intent(inout) :: value   !! unchanged if the command line gives none
    logical, intent(out) :: found
    integer :: i

    i = position(list, name)
    found = i > 0
    if (.not. found) return
    associate (setting => list(i))
      if (setting%used) then
        found = .not. counts .and. setting%place%line == place%line .and. &
                setting%place%file == place%file
      end if
      if (.not. found) return
      if (.not. setting%used) setting%place = place
      setting%used = .true.
      value = setting%value
    end associate
  end subroutine use_setting

  !> Check that the deck sets every parameter that the command line sets.
  subroutine check_used(list, params, error)
    type(setting_t), intent(in) :: list(:)
    type(params_t), intent(in) :: params !! all parameters, after the deck has been read
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint
    integer :: i

    do i = 1, size(list)
      if (list(i)%used) cycle
      hint = nearest(list(i)%name, parameter_names(params))
      if (len(hint) > 0) then
        hint = 'nearest known: '//hint
      else
        hint = 'the deck sets no parameters'
      end if
      call fail(error, DECK_ERROR, 'the deck does not set parameter '//quoted(list(i)%name) &
                //', to which --set gives a value', hint=hint)
      return
    end do
  end subroutine check_used

  !> Text with one line for each setting, written as comments of a deck.
  function settings_text(list) result(text)
    type(setting_t), intent(in) :: list(:)
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(list)
      text = text//new_line('a')//'! --set '//list(i)%name//'='//to_text(list(i)%value, 17)
    end do
  end function settings_text

end module deck_settings
