!> ARCLength: how the path goes on where load control ends. TRANsient, MASS: motion in time.
module command_path
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: quoted
  use command_type, only: run_t, command_t, command_row_t, new_row
  use dynamics_type, only: new_dynamics, BACKWARD_EULER, NEWMARK, HHT
  use energy_type, only: open_book
  use path_type, only: path_t, PATH_OFF, PATH_DYNAMIC, PATH_LOCAL, PATH_LENGTH
  implicit none
  private
  public :: describe_arcl, describe_tran, describe_mass

contains

  function describe_arcl() result(row)
    type(command_row_t) :: row

    row = new_row('ARCLength', &
                  'ARCLength,[LOCAl|LENGth|DYNAmic|OFF],[share|multiple|density]', 2, run_arcl)
  end function describe_arcl

  function describe_tran() result(row)
    type(command_row_t) :: row

    row = new_row('TRANsient', 'TRANsient,BACK|NEWMark|HHT|OFF,[beta],[gamma],[alpha]', 4, run_tran)
  end function describe_tran

  function describe_mass() result(row)
    type(command_row_t) :: row

    row = new_row('MASS', 'MASS,[CONSistent|LUMPed]', 1, run_mass)
  end function describe_mass

  !> What follows where load control ends.
  subroutine run_arcl(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(path_t) :: default

    call check_way(run, command, error)
    if (allocated(error)) return
    if (run%dry) return
    run%path%given = .true.
    run%path%density = -1.0_wp
    select case (command%option)
    case ('off')
      run%path%method = PATH_OFF
    case ('leng')
      run%path%method = PATH_LENGTH
      run%path%multiple = default%multiple
      if (command%x(1) > 0.0_wp) run%path%multiple = command%x(1)
    case ('dyna')
      run%path%method = PATH_DYNAMIC
      if (command%x(1) > 0.0_wp) run%path%density = command%x(1)
    case default
      run%path%method = PATH_LOCAL
      run%path%largest = default%largest
      if (command%x(1) > 0.0_wp) run%path%largest = command%x(1)
    end select
    if (.not. allocated(run%state%dynamics%v)) then
      call new_dynamics(run%state%dynamics, run%model%mesh%nnode)
    end if
    if (.not. run%state%energy%on) call open_book(run%state%energy, run%model%mesh%nnode)
  end subroutine run_arcl

  !> The way and its number.
  subroutine check_way(run, command, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (all(command%option /= ['    ', 'dyna', 'leng', 'loca', 'off '])) then
      call fail(error, DECK_ERROR, 'unknown way to follow a path, ' &
                //quoted(command%record%text(2)), command%record%place(2), &
                'ARCLength,DYNAmic,[density] | LOCAl,[share] | LENGth,[multiple] | ' &
                //'OFF')
    else if (command%option == 'leng') then
      if (command%x(1) >= 1.0_wp .or. .not. abs(command%x(1)) > 0.0_wp) return
      call fail(error, DECK_ERROR, 'the longest step is no shorter than the first', &
                command%record%place(3), 'leave it out: four times the first')
    else if (command%option /= 'loca') then
      if (command%x(1) >= 0.0_wp) return
      call fail(error, DECK_ERROR, 'a density is positive', command%record%place(3), &
                'leave it out: it is then chosen from the work done')
    else if (.not. any(run%model%contact(:)%has_cohesive)) then
      call fail(error, DECK_ERROR, 'LOCAl controls the release of bonds, and there are none', &
                command%record%place(2), 'a CONTact with COHEsive has bonds; else ' &
                //'ARCLength,DYNAmic')
    else if (command%x(1) < 0.0_wp .or. command%x(1) >= 1.0_wp) then
      call fail(error, DECK_ERROR, 'the share of the bonds that a step releases lies between ' &
                //'0 and 1', command%record%place(3), 'leave it out: a hundredth')
    end if
  end subroutine check_way

  !> Bodies move in time, from rest, with the densities of their materials (FEAP).
  subroutine run_tran(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_scheme(run, command, error)
    if (allocated(error) .or. run%dry) return
    associate (dynamics => run%state%dynamics)
      if (any(command%option == ['off ', 'stat'])) then
        dynamics%on = .false.
        return
      end if
      if (.not. allocated(dynamics%v)) call new_dynamics(dynamics, run%model%mesh%nnode)
      dynamics%on = .true.
      dynamics%density = -1.0_wp
      run%path%given = .true.
      run%path%method = PATH_OFF
      if (allocated(run%newton%asm%mass)) deallocate (run%newton%asm%mass)
      call set_scheme(command, dynamics%method, dynamics%beta, dynamics%gamma, dynamics%alpha)
    end associate
  end subroutine run_tran

  subroutine check_scheme(run, command, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = &
                               'TRANsient,BACK | NEWMark,beta,gamma | HHT,beta,gamma,alpha | OFF'
    real(wp) :: beta, gamma, alpha
    integer :: method

    if (all(command%option /= ['back', 'newm', 'hht ', 'off ', 'stat'])) then
      call fail(error, DECK_ERROR, 'unknown time integration '//quoted(command%record%text(2)), &
                command%record%place(2), USAGE)
      return
    end if
    call set_scheme(command, method, beta, gamma, alpha)
    if (.not. (beta > 0.0_wp .and. gamma >= 0.5_wp .and. alpha <= 0.0_wp &
               .and. alpha > -1.0_wp)) then
      call fail(error, DECK_ERROR, 'the time integration needs beta > 0, gamma >= 1/2, ' &
                //'-1 < alpha <= 0', command%record%place(3), USAGE)
      return
    end if
    if (any(command%option == ['off ', 'stat'])) return
    if (any(run%model%material(:)%density > 0.0_wp)) return
    call fail(error, DECK_ERROR, 'no material has a density', command%record%place(1), &
              'write DENSity,,rho in the MATErial')
  end subroutine check_scheme

  !> Parameters as given, or those of FEAP: 1/4 and 1/2; HHT's follow from alpha, -0.05.
  pure subroutine set_scheme(command, method, beta, gamma, alpha)
    type(command_t), intent(in) :: command
    integer, intent(out) :: method
    real(wp), intent(out) :: beta, gamma, alpha

    method = BACKWARD_EULER
    if (command%option == 'newm') method = NEWMARK
    if (command%option == 'hht') method = HHT
    alpha = 0.0_wp
    if (method == HHT) then
      alpha = -0.05_wp
      if (abs(command%x(3)) > 0.0_wp) alpha = command%x(3)
    end if
    beta = 0.25_wp*(1.0_wp - alpha)**2
    gamma = 0.5_wp - alpha
    if (abs(command%x(1)) > 0.0_wp) beta = command%x(1)
    if (abs(command%x(2)) > 0.0_wp) gamma = command%x(2)
  end subroutine set_scheme

  !> Consistent masses (default) or lumped ones.
  subroutine run_mass(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (all(command%option /= ['    ', 'cons', 'lump'])) then
      call fail(error, DECK_ERROR, 'unknown kind of mass '//quoted(command%record%text(2)), &
                command%record%place(2), 'MASS,CONSistent or MASS,LUMPed')
      return
    end if
    if (run%dry) return
    run%state%dynamics%lumped = command%option == 'lump'
    if (allocated(run%newton%asm%mass)) deallocate (run%newton%asm%mass)
  end subroutine run_mass

end module command_path
