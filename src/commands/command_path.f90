!> ARCLength selects how the equilibrium path is continued when load control fails; TRANsient and
!! MASS select dynamics.
module command_path
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: quoted, to_text
  use command_step, only: finish_solved_step
  use command_type, only: run_t, command_t, command_row_t, new_row, has_number, check_fields
  use continuation_type, only: continuation_t, PATH_OFF, PATH_INERTIA, PATH_RELEASE, PATH_ARC, &
                               BY_INERTIA, set_multiple
  use dynamics_type, only: new_dynamics, BACKWARD_EULER, NEWMARK, HHT
  use mesh, only: is_rigid
  use step, only: begin_again, return_to_load
  use uneven_steps, only: warn_scheme
  implicit none
  private
  public :: path_rows

  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! tolerance for parameters of the time integration

contains

  function path_rows() result(row)
    type(command_row_t) :: row(3)

    row(1) = new_row('ARCLength', &
                     'ARCLength,[LOCAl|LENGth|DYNAmic|OFF],[fraction|multiple|density]', 2, &
                     run_arcl)
    row(2) = new_row('TRANsient', 'TRANsient,BACK|NEWMark|HHT|OFF,[beta],[gamma],[alpha]', 4, &
                     run_tran)
    row(3) = new_row('MASS', 'MASS,[CONSistent|LUMPed]', 1, run_mass)
  end function path_rows

  !> Set the method that continues the path when load control fails, and its parameter.
  subroutine run_arcl(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(continuation_t) :: default
    real(wp) :: x
    logical :: given, rewound
    integer :: method

    call check_fields(command, merge(0, 1, command%option == 'off'), &
                      trim(run%program%row(command%row)%usage), error)
    if (allocated(error)) return
    given = has_number(command, 1) .and. command%option /= ''
    x = merge(command%x(1), 0.0_wp, given)
    associate (record => command%record)
      if (all(command%option /= ['    ', 'dyna', 'leng', 'loca', 'off '])) then
        call fail(error, DECK_ERROR, 'unknown method of continuation '//quoted(record%text(2)), &
                  record%place(2), 'ARCLength,DYNAmic,[density] | LOCAl,[fraction] ' &
                  //'| LENGth,[multiple] | OFF')
      else if (command%option == 'leng') then
        if (given .and. .not. x >= 1.0_wp) then
          call fail(error, DECK_ERROR, 'expected a multiple of at least 1, found '//to_text(x), &
                    record%place(3), 'the multiple is the length of the ' &
                    //'longest step divided by that of the first; the default is 4')
        else if (any(run%model%contact%cohesive%tau > 0.0_wp)) then
          call fail(error, DECK_ERROR, 'ARCLength,LENGth cannot be used together with VISCous', &
                    record%place(2), 'with LENGth the time may decrease, but the traction of ' &
                    //'VISCous depends on rates: use ARCLength,DYNAmic, or remove VISCous')
        end if
      else if (command%option /= 'loca') then
        if (x < 0.0_wp .or. given .and. .not. x > 0.0_wp) then
          call fail(error, DECK_ERROR, 'expected a positive density, found '//to_text(x), &
                    record%place(3), 'omit the density; it is then chosen from the work done')
        end if
      else if (.not. any(run%model%contact(:)%cohesive%given)) then
        call fail(error, DECK_ERROR, 'LOCAl controls the release of bonds, but the model has no ' &
                  //'bonds', record%place(2), 'define a CONTact with COHEsive, or use ' &
                  //'ARCLength,DYNAmic')
      else if (x < 0.0_wp .or. x >= 1.0_wp .or. given .and. .not. x > 0.0_wp) then
        call fail(error, DECK_ERROR, 'expected a fraction of the bonds between 0 and 1, found ' &
                  //to_text(x), record%place(3), 'omit the fraction to use the default, 0.01')
      end if
    end associate
    if (allocated(error)) return
    if (command%option /= 'off' .and. moves(run)) then
      call fail(error, DECK_ERROR, 'ARCLength cannot continue a motion of TRANsient', &
                command%record%place(1), 'a motion is never in equilibrium: remove ARCLength, or ' &
                //'write TRANsient,OFF before it')
      return
    end if
    if (run%program%dry) then
      if (abs(command%x(1)) > 0.0_wp .and. .not. given) call log_line( &
        "note: the number of FEAP's arc length method is ignored")
      return
    end if
    select case (command%option)
    case ('off')
      method = PATH_OFF
    case ('leng')
      method = PATH_ARC
    case ('dyna')
      method = PATH_INERTIA
    case default
      method = PATH_RELEASE
    end select
    if (method /= run%step%continuation%method) then
      call finish_solved_step(run, rewound, error)
      if (allocated(error) .or. rewound) return
      call return_to_load(run%step, run%model, run%state)
    end if
    associate (path => run%step%continuation)
      path%method = method
      path%given = .true.
      path%density = -1.0_wp
      select case (method)
      case (PATH_ARC)
        call set_multiple(path, merge(x, default%multiple, x > 0.0_wp))
      case (PATH_INERTIA)
        if (x > 0.0_wp) path%density = x
      case (PATH_RELEASE)
        path%largest_release = merge(x, default%largest_release, x > 0.0_wp)
      case default ! OFF has no parameter
      end select
    end associate
    if (.not. allocated(run%state%dynamics%v)) then
      call new_dynamics(run%state%dynamics, run%model%mesh%nnode)
    end if
  end subroutine run_arcl

  !> Does TRANsient act? When commands are only checked, this is known from those before the present
  !! one, but not from those after it in a loop.
  pure logical function moves(run)
    type(run_t), intent(in) :: run
    integer :: i

    moves = run%state%dynamics%on .and. run%state%dynamics%density < 0.0_wp
    if (.not. run%program%dry) return
    do i = run%program%counter - 1, 1, -1
      associate (record => run%program%command(i)%record)
        if (record%key(1) /= 'tran') cycle
        moves = all(record%key(2) /= ['off ', 'stat'])
        return
      end associate
    end do
  end function moves

  !> Switch dynamics on or off (FEAP). When it is switched on, the bodies start from rest, except in
  !! a motion that RESTart has read. Their masses follow from the densities of their materials.
  subroutine run_tran(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = &
                               'TRANsient,BACK | NEWMark,beta,gamma | HHT,beta,gamma,alpha | OFF'
    real(wp) :: beta, gamma, alpha
    integer :: method, nnumber
    logical :: off, rewound

    if (all(command%option /= ['back', 'newm', 'hht ', 'off ', 'stat'])) then
      call fail(error, DECK_ERROR, 'unknown time integration '//quoted(command%record%text(2)), &
                command%record%place(2), USAGE)
      return
    end if
    nnumber = 0
    if (command%option == 'newm') nnumber = 2
    if (command%option == 'hht') nnumber = 3
    call check_fields(command, nnumber, USAGE, error)
    if (allocated(error)) return
    call set_scheme(command, method, beta, gamma, alpha)
    off = any(command%option == ['off ', 'stat'])
    if (.not. (beta > 0.0_wp .and. gamma >= 0.5_wp .and. alpha <= 0.0_wp &
               .and. alpha > -1.0_wp)) then
      call fail(error, DECK_ERROR, 'the time integration needs beta > 0, gamma >= 1/2 and -1 < ' &
                //'alpha <= 0', command%record%place(3), USAGE)
    else if (gamma < 0.5_wp - alpha - ROUNDING) then
      call fail(error, DECK_ERROR, 'gamma = '//to_text(gamma)//' is less than 1/2 - alpha = ' &
                //to_text(0.5_wp - alpha)//': motions would grow without bound', &
                command%record%place(4), 'leave beta and gamma empty: TRANsient,HHT,,,alpha')
    else if (.not. off .and. run%program%dry) then
      call check_masses(run, command, error)
      call warn_unstable(command, beta, gamma, alpha)
    end if
    if (allocated(error) .or. run%program%dry) return
    if (off) run%state%dynamics%continues = .false. ! a motion of a checkpoint ends, too
    if (off .and. .not. (run%state%dynamics%on .or. &
                         run%step%continuation%active == BY_INERTIA)) return
    call finish_solved_step(run, rewound, error)
    if (allocated(error) .or. rewound) return
    if (.not. off .or. run%step%continuation%active == BY_INERTIA) then
      call return_to_load(run%step, run%model, run%state)
    end if
    associate (dynamics => run%state%dynamics)
      if (.not. (off .or. dynamics%on .or. dynamics%continues)) then
        call new_dynamics(dynamics, run%model%mesh%nnode)
      end if
      if (.not. off .and. (dynamics%on .or. dynamics%continues)) then
        call warn_scheme(run%model, run%state, method, command%record%place(1))
      end if
      dynamics%on = .not. off
      if (off) return
      dynamics%density = -1.0_wp
      run%step%continuation%given = .true. ! no inertia other than that of this scheme
      run%step%continuation%method = PATH_OFF
      if (allocated(run%step%newton%asm%mass)) deallocate (run%step%newton%asm%mass)
      dynamics%method = method
      dynamics%beta = beta
      dynamics%gamma = gamma
      dynamics%alpha = alpha
    end associate
    call begin_again(run%step, run%model, run%state) ! with the coefficients of the new scheme
  end subroutine run_tran

  !> Warn about parameters for which long steps are unstable.
  !!
  !! For an oscillator of frequency w, let W = (w dt)^2. With the amplification factors of a step
  !! written as z = (1 + s)/(1 - s), the s are the zeros of
  !!
  !!   4 s^2 (1 + s) + W (1 + A s)(1 + B s + C s^2),
  !!
  !! where A = 1 + 2 alpha, B = 2 gamma - 1 and C = 4 beta - 2 gamma. No |z| exceeds 1, however
  !! large W is, if A >= 0, A + B >= 1 and C >= 0 (Routh and Hurwitz); if A + B < 1, the scheme is
  !! unstable for every small W.
  subroutine warn_unstable(command, beta, gamma, alpha)
    type(command_t), intent(in) :: command
    real(wp), intent(in) :: beta, gamma, alpha
    real(wp), parameter :: MOST_DISSIPATIVE = -1.0_wp/3.0_wp

    if (2.0_wp*beta < gamma - ROUNDING) then
      call warn('2 beta = '//to_text(2.0_wp*beta)//' is less than gamma = '//to_text(gamma) &
                //': motions grow without bound in long steps', command%record%place(3), &
                'give beta = '//to_text(0.25_wp*(gamma + 0.5_wp)**2)//', for instance: schemes ' &
                //'with 2 beta >= gamma and alpha >= -1/2 are stable in steps of any length')
    else if (alpha < -0.5_wp - ROUNDING) then
      call warn('alpha = '//to_text(alpha)//' is less than -1/2: motions grow without bound in ' &
                //'long steps', command%record%place(5), 'use -1/3 <= alpha <= 0')
    else if (alpha < MOST_DISSIPATIVE - 1.0e-3_wp) then
      call warn('alpha = '//to_text(alpha)//' dissipates high frequencies less than alpha = -1/3 ' &
                //'does', command%record%place(5), 'use -1/3 <= alpha <= 0')
    end if
  end subroutine warn_unstable

  !> Fail if no body has a mass; warn once about each material of a body that has no density.
  subroutine check_masses(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: used(size(run%model%material))
    integer :: b, m

    used = .false.
    do b = 1, size(run%model%mesh%block)
      associate (block => run%model%mesh%block(b))
        if (.not. is_rigid(block)) used(block%material) = .true.
      end associate
    end do
    associate (material => run%model%material)
      if (.not. any(used .and. material%density > 0.0_wp)) then
        call fail(error, DECK_ERROR, 'TRANsient needs masses, but no material of a body has a ' &
                  //'density', command%record%place(1), 'write DENSity,,rho in the MATErial')
        return
      end if
      if (run%program%noted(command%row)) return
      run%program%noted(command%row) = .true.
      do m = 1, size(material)
        if (.not. used(m) .or. material(m)%density > 0.0_wp) cycle
        call warn('TRANsient needs masses, but material '//to_text(material(m)%number)//' has no ' &
                  //'density', material(m)%place, 'write DENSity,,rho; without it, bodies of ' &
                  //'this material follow the others without inertia')
      end do
    end associate
  end subroutine check_masses

  !> Set the parameters given in the deck, or else those of FEAP: 1/4 and 1/2; for HHT they follow
  !! from alpha, whose default is -0.05. As in FEAP, a beta or gamma of 0 is replaced; an alpha of 0
  !! gives Newmark's scheme.
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
      if (has_number(command, 3)) alpha = command%x(3)
    end if
    beta = 0.25_wp*(1.0_wp - alpha)**2
    gamma = 0.5_wp - alpha
    if (abs(command%x(1)) > 0.0_wp) beta = command%x(1)
    if (abs(command%x(2)) > 0.0_wp) gamma = command%x(2)
  end subroutine set_scheme

  !> Choose consistent masses (the default) or lumped ones.
  subroutine run_mass(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: rewound

    if (all(command%option /= ['    ', 'cons', 'lump'])) then
      call fail(error, DECK_ERROR, 'unknown type of mass '//quoted(command%record%text(2)), &
                command%record%place(2), 'MASS,CONSistent or MASS,LUMPed')
      return
    end if
    if (run%program%dry) return
    call finish_solved_step(run, rewound, error)
    if (allocated(error) .or. rewound) return
    run%state%dynamics%lumped = command%option == 'lump'
    if (allocated(run%step%newton%asm%mass)) deallocate (run%step%newton%asm%mass)
    call begin_again(run%step, run%model, run%state)
  end subroutine run_mass

end module command_path
