!> DISP, REAC, STRE: FEAP's tables in <stem>.out; PRIN and NOPR turn them on and off.
module command_print
  use base_agreement, only: agree
  use base_comm, only: is_root
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use command_files, only: open_tables, keep_tables
  use command_type, only: run_t, command_t, command_row_t, new_row, whole_field, check_fields, &
                          has_number
  use input_numbers, only: warn_number
  use mesh, only: is_rigid
  use newton, only: form_system
  use newton_type, only: pass_t
  use print_tables, only: print_displacements, print_reactions, print_stresses, print_nodal_stresses
  implicit none
  private
  public :: print_rows

contains

  function print_rows() result(row)
    type(command_row_t) :: row(5)

    row(1) = new_row('DISPlacement', 'DISP,[ALL | COOR,d,x],[n1],[n2],[step]', 4, run_print)
    row(2) = new_row('REACtion', 'REAC,[ALL | COOR,d,x],[n1],[n2],[step]', 4, run_print)
    row(3) = new_row('STREss', 'STRE,[ALL | NODE | COOR,d,x],[n1],[n2],[step]', 4, run_print)
    row(4) = new_row('PRINt', 'PRINt', 1, run_switch)
    row(5) = new_row('NOPRint', 'NOPRint', 1, run_switch)
  end function print_rows

  subroutine run_switch(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_fields(command, 0, trim(run%program%row(command%row)%usage), error, option=.false.)
    if (allocated(error)) return
    if (.not. run%program%dry) run%plan%prints = command%record%key(1) == 'prin'
  end subroutine run_switch

  !> Print one table: of every step-th node or element from n1 to n2, of the nodes in the plane
  !! x_d = x (COOR), or of all nodes or elements if no numbers are given.
  subroutine run_print(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(pass_t) :: pass
    integer :: first, last, step

    call read_range(run, command, first, last, step, error)
    if (allocated(error)) return
    if (run%program%dry .and. command%visit == 1) call warn_short(run, command, first, last, step)
    if (run%program%dry .or. .not. run%plan%prints) return
    call open_tables(run, error)
    if (allocated(error)) return
    if (command%record%key(1) == 'reac') call warn_changed_loads(run, command)
    if (run%step%open .and. run%step%solved .and. command%record%key(1) /= 'disp') then
      ! After a solve, forces and stresses are outdated.
      call form_system(run%step%newton, run%model, run%state, run%step%newton%symmetric, pass, &
                       error)
      if (allocated(error)) return
    end if
    if (is_root()) call write_table(run, command, first, last, step, error)
    call agree(error)
    if (.not. (allocated(error) .or. run%step%open)) call keep_tables(run)
  end subroutine run_print

  !> Warn if reactions are printed after RESTart and before the first solve, but the loads are not
  !! those of the checkpoint.
  subroutine warn_changed_loads(run, command)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command

    if (.not. run%plan%loads_changed .or. run%step%open) return
    if (run%state%step /= run%plan%restarted_at) return
    call warn('REACtion prints the forces of the checkpoint with the loads of this deck, which ' &
              //'differ from those of the checkpoint', command%record%place(1), &
              'solve a step before REACtion')
  end subroutine warn_changed_loads

  subroutine write_table(run, command, first, last, step, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(in) :: first, last, step
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: list(:)
    real(wp), allocatable :: before ! time of the last step, until this one is solved

    if (run%step%open .and. run%step%timed .and. .not. run%step%solved) before = run%plan%closed_at
    associate (out => run%files%out, model => run%model, state => run%state)
      if (command%record%key(1) == 'stre' .and. all(command%option /= ['node', 'coor'])) then
        call print_stresses(out, model, state, first, last, step, error, before)
        return
      end if
      list = nodes_of_table(run, command, first, last, step)
      select case (command%record%key(1))
      case ('disp')
        call print_displacements(out, model, state, list, error, before)
      case ('reac')
        call print_reactions(out, model, state, formed_factors(run), list, error, before)
      case default
        call print_nodal_stresses(out, model, state, list, error, before)
      end select
    end associate
  end subroutine write_table

  !> The load factors with which the reactions were formed: those of the current step or, before
  !! forces have been formed in it, those at the end of the previous one.
  function formed_factors(run) result(factor)
    type(run_t), intent(in) :: run
    real(wp), allocatable :: factor(:)

    if (run%step%open .and. .not. run%step%newton%begins) then
      factor = run%state%factor
    else if (allocated(run%state%factor_step)) then
      factor = run%state%factor_step
    else
      factor = [0.0_wp] ! no forces have been formed
    end if
  end function formed_factors

  !> Nodes of a table: those from `first` to `last` that exist or, with COOR, those on the plane.
  function nodes_of_table(run, command, first, last, step) result(list)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(in) :: first, last, step
    integer, allocatable :: list(:)
    integer :: d, i
    real(wp) :: gap

    list = pack([(i, i=first, last, step)], run%model%mesh%used(first:last:step))
    if (command%option /= 'coor') return
    d = nint(command%x(1))
    associate (x => run%model%mesh%xr)
      gap = 1.0e-3_wp/sqrt(real(size(x, 2), wp))*(maxval(x(d, list)) - minval(x(d, list)))
      list = pack(list, [(abs(x(d, list(i)) - command%x(2)) <= gap, i=1, size(list))])
    end associate
  end function nodes_of_table

  !> Warn if no node lies on the plane of COOR, if a range ends before it begins, or if its numbers
  !! are not those of the nodes or elements that are meant.
  subroutine warn_short(run, command, first, last, step)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(in) :: first, last, step
    integer :: d

    associate (record => command%record)
      if (command%option == 'coor') then
        if (size(nodes_of_table(run, command, first, last, step)) > 0) return
        d = nint(command%x(1))
        associate (x => run%model%mesh%xr(d, :), used => run%model%mesh%used)
          call warn('no node has the coordinate '//to_text(d)//' equal to ' &
                    //to_text(command%x(2), 4)//': the table of '//record%text(1)//' is empty', &
                    record%place(min(4, record%n)), 'the coordinates '//to_text(d) &
                    //' of the nodes are between '//to_text(minval(x, used), 4)//' and ' &
                    //to_text(maxval(x, used), 4)//', before any displacement')
        end associate
      else if (command%x(2) > 0.5_wp .and. command%x(2) < command%x(1)) then
        call warn('the range of '//record%text(1)//' ends before it begins: only number ' &
                  //to_text(first)//' is printed', record%place(4), &
                  'give the smaller number first')
      end if
      if (command%option == 'coor' .or. command%option == 'all') return
      if (record%key(1) == 'stre' .and. command%option /= 'node') then
        call warn_elements(run, command, first, last, step)
      else if (has_number(command, 1)) then
        call warn_nodes(run, command, first, last)
      end if
    end associate
  end subroutine warn_short

  !> Warn if the first or the last node of a range has another number in its mesh file, or belongs
  !! to no element, as do those that TIE has joined with others. The range of all nodes is accepted.
  subroutine warn_nodes(run, command, first, last)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(in) :: first, last
    integer :: i, node
    logical :: told

    associate (mesh => run%model%mesh, record => command%record)
      if (first == 1 .and. last == mesh%nnode) return
      told = .false.
      do i = 1, merge(1, 2, first == last)
        node = merge(first, last, i == 1)
        call warn_number(mesh, node, record%place(i + 2), told)
        if (mesh%used(node)) cycle
        call warn('node '//to_text(node)//' is not in the table of '//record%text(1) &
                  //', because it belongs to no element', record%place(i + 2), &
                  'if TIE has joined it with another node, give the lowest number of these, or ' &
                  //record%text(1)//',COOR')
        return
      end do
    end associate
  end subroutine warn_nodes

  !> Warn if no element has a number of the range.
  subroutine warn_elements(run, command, first, last, step)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(in) :: first, last, step
    integer :: b, least, most

    least = huge(1)
    most = 0
    do b = 1, size(run%model%mesh%block)
      if (is_rigid(run%model%mesh%block(b))) cycle
      associate (number => run%model%mesh%block(b)%number)
        if (any(number >= first .and. number <= last .and. &
                modulo(number - first, step) == 0)) return
        least = min(least, minval(number))
        most = max(most, maxval(number))
      end associate
    end do
    if (most == 0) return
    call warn('no element has a number from '//to_text(first)//' to '//to_text(last) &
              //': the table of '//command%record%text(1)//' is empty', command%record%place(1), &
              'the numbers of elements are between '//to_text(least)//' and '//to_text(most))
  end subroutine warn_elements

  subroutine read_range(run, command, first, last, step, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(out) :: first, last, step
    type(error_t), allocatable, intent(out) :: error
    integer :: b, i, most, nnumber, number(3)

    if (all(command%option /= ['    ', 'all ', 'node', 'coor']) .or. &
        (command%option == 'node' .and. command%record%key(1) /= 'stre')) then
      call fail(error, DECK_ERROR, "unknown option '"//command%record%text(2)//"'", &
                command%record%place(2), trim(run%program%row(command%row)%usage))
      return
    end if
    nnumber = 3
    if (command%option == 'all') nnumber = 0
    if (command%option == 'coor') nnumber = 2
    call check_fields(command, nnumber, trim(run%program%row(command%row)%usage), error)
    if (allocated(error)) return
    most = run%model%mesh%nnode
    if (command%record%key(1) == 'stre' .and. all(command%option /= ['node', 'coor'])) then
      most = 0 ! numbers of a mesh file may have gaps
      do b = 1, size(run%model%mesh%block)
        most = max(most, maxval([0, run%model%mesh%block(b)%number]))
      end do
    end if
    first = 1
    last = most
    step = 1
    if (command%option == 'coor' .and. all(abs(command%x(1) - [1, 2, 3]) > 0)) then
      call fail(error, DECK_ERROR, 'expected direction 1, 2 or 3', &
                command%record%place(min(3, command%record%n)), &
                trim(run%program%row(command%row)%usage))
    end if
    if (any(command%option == ['all ', 'coor'])) return
    do i = 1, 3
      call whole_field(command, i, number(i), error)
    end do
    call check_range(run, command, number, error)
    if (allocated(error) .or. number(1) == 0) return
    first = number(1)
    last = max(first, number(2))
    step = max(1, number(3))
    if (last > most) then
      call fail(error, DECK_ERROR, 'the range ends at number '//to_text(last)//', but the ' &
                //'largest number in the mesh is '//to_text(most), command%record%place(4), &
                trim(run%program%row(command%row)%usage))
    end if
  end subroutine read_range

  !> Fail if a number of a range is negative, or if it has no effect because the first one is
  !! missing or 0, so that all nodes or elements would be printed.
  subroutine check_range(run, command, number, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    integer, intent(in) :: number(3) !! first, last, step; 0: not given
    type(error_t), allocatable, intent(inout) :: error !! keep an earlier error
    character(:), allocatable :: usage
    integer :: i

    if (allocated(error)) return
    usage = trim(run%program%row(command%row)%usage)
    do i = 1, 3
      if (number(i) < 0) then
        call fail(error, DECK_ERROR, 'expected a positive number, found '//to_text(number(i)), &
                  command%record%place(i + 2), usage)
        return
      else if (number(i) > 0 .and. number(1) == 0) then
        call fail(error, DECK_ERROR, 'the range of '//command%record%text(1) &
                  //' has no first number', command%record%place(i + 2), usage)
        return
      end if
    end do
  end subroutine check_range

end module command_print
