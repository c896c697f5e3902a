!> Warnings about commands that are probably not intended; they are issued when the whole deck has
!! been read.
module command_doubts
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use command_type, only: run_t
  use inertia, only: count_scaled
  use mesh, only: is_rigid
  use table_use, only: warn_tables
  implicit none
  private
  public :: warn_commands

contains

  !> Warn about load tables without loads, about commands that come after all commands that they
  !! could affect, and about commands that have no effect without other commands.
  subroutine warn_commands(run)
    type(run_t), intent(in) :: run

    call warn_tables(run)
    call warn_late(run)
    if (first(run, 'tran') == 0) then
      call warn_idle(run, 'mass', 'MASS has no effect without TRANsient', &
                     'add TRANsient to compute with inertia, or remove MASS')
    else if (first(run, 'time') == 0) then
      call warn_idle(run, 'tran', 'TRANsient has no effect without TIME: the single step at t = ' &
                     //'0 has no inertia', 'add DT,,dt and a loop with TIME to the commands')
    else
      call warn_scaled(run)
    end if
  end subroutine warn_commands

  !> Warn of elements with which a uniform acceleration causes stress if masses are lumped.
  subroutine warn_scaled(run)
    type(run_t), intent(in) :: run
    integer :: b, i, n

    do i = 1, size(run%program%command)
      associate (command => run%program%command(i))
        if (command%record%key(1) /= 'mass' .or. command%record%key(2) /= 'lump') cycle
        do b = 1, size(run%model%mesh%block)
          associate (block => run%model%mesh%block(b))
            if (is_rigid(block)) cycle
            if (.not. run%model%material(block%material)%density > 0.0_wp) cycle
            n = count_scaled(block, run%model%mesh%xr)
            if (n == 0) cycle
            call warn('the masses of '//to_text(n)//' of '//to_text(block%nelem)//' elements ' &
                      //trim(block%name)//' are a scaled diagonal, because row sums of their ' &
                      //'mass matrices are not positive: a uniform acceleration causes stress in ' &
                      //'them', command%record%place(1), 'use MASS,CONSistent')
          end associate
        end do
        return
      end associate
    end do
  end subroutine warn_scaled

  !> Warn about commands that prepare steps or solves if all of these come before them.
  subroutine warn_late(run)
    type(run_t), intent(in) :: run
    character(4), parameter :: SOLVES(4) = ['tang', 'utan', 'solv', 'form']
    integer :: i

    do i = 1, size(run%program%command)
      select case (run%program%command(i)%record%key(1))
      case ('tol ', 'fact')
        if (is_late(run, i, SOLVES)) call warn_here(run, i, 'TANG or UTAN')
      case ('arcl', 'auto')
        if (is_late(run, i, [SOLVES, 'time'])) call warn_here(run, i, 'TIME, TANG or UTAN')
      case ('dt  ', 'tran', 'mass')
        if (is_late(run, i, ['time'])) call warn_here(run, i, 'TIME')
      case default
        cycle
      end select
    end do
  end subroutine warn_late

  subroutine warn_here(run, i, needed)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(*), intent(in) :: needed

    associate (command => run%program%command(i))
      call warn(trim(run%program%row(command%row)%word)//' comes too late: no '//needed &
                //' follows it', command%record%place(1), &
                'put it before the commands that it is to affect')
    end associate
  end subroutine warn_here

  !> Do commands with the given names run, but only before command i? Those that are before it in a
  !! loop that contains it also run after it, in the next pass.
  pure logical function is_late(run, i, key) result(late)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(4), intent(in) :: key(:)
    integer :: j, start

    associate (list => run%program%command)
      start = i
      do j = 1, i - 1
        if (list(j)%record%key(1) == 'loop' .and. list(j)%matching > i) exit
      end do
      if (j < i) start = j
      late = .not. any([(any(key == list(j)%record%key(1)), j=start, size(list))]) .and. &
             any([(any(key == list(j)%record%key(1)), j=1, start)])
    end associate
  end function is_late

  !> Warn at the first command with a given name, if there is one.
  subroutine warn_idle(run, key, message, hint)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key
    character(*), intent(in) :: message, hint
    integer :: i

    i = first(run, key)
    if (i > 0) call warn(message, run%program%command(i)%record%place(1), hint)
  end subroutine warn_idle

  !> Position of the first command with a given name; 0: there is none.
  pure integer function first(run, key) result(i)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key

    do i = 1, size(run%program%command)
      if (run%program%command(i)%record%key(1) == key) return
    end do
    i = 0
  end function first

end module command_doubts
