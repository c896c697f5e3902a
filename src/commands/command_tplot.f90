!> TPLOt: histories of nodal values in <stem>_tplot.dat, with one row every `interval` steps.
module command_tplot
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text
  use command_step, only: finish_solved_step
  use command_type, only: run_t, command_t, command_row_t, new_row, data_t, whole_field, &
                          check_fields
  use curve_type, only: curve_t, quantity_t, Q_NODAL, Q_DISP
  use deck_record, only: record_t, check_count, RECORD_WORDS
  use deck_stream, only: get_integer, get_real
  use input_numbers, only: warn_number
  use input_rigid, only: warn_part_of_rigid
  use input_where, only: check_near, nearest_nodes, warn_between
  implicit none
  private
  public :: tplot_rows

  character(*), parameter :: USAGE = '''DISP|REAC,node,direction'' or, for the node nearest to ' &
                             //'x y z, ''DISP|REAC,0,direction,x,y,z'''

contains

  function tplot_rows() result(row)
    type(command_row_t) :: row(1)

    row(1) = new_row('TPLOt', 'TPLOt,,interval; its records DISP or REAC come after END', &
                     2, run_tplot, read_tplot)
  end function tplot_rows

  subroutine run_tplot(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: every
    logical :: rewound

    call whole_field(command, 1, every, error)
    call check_fields(command, 1, 'TPLOt,,interval', error, option=.false.)
    if (allocated(error) .or. run%program%dry) return
    if (max(1, every) == run%plan%tplot_every) return
    call finish_solved_step(run, rewound, error) ! its row is written with the former interval
    if (allocated(error) .or. rewound) return
    run%plan%tplot_every = max(1, every)
  end subroutine run_tplot

  !> Read the records; those of all TPLOt commands form one curve. FEAP's SHOW has no effect here.
  subroutine read_tplot(run, command, data, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(data_t), intent(out) :: data
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(curve_t) :: curve
    type(quantity_t) :: quantity
    logical :: told
    integer :: i

    told = .false.
    allocate (data%assignment(0))
    curve%name = 'tplot'
    curve%place = command%record%place(1)
    allocate (curve%quantity(0))
    do
      call run%deck%next_of_set(record, error)
      if (allocated(error)) return
      if (record%kind /= RECORD_WORDS) exit
      if (record%key(1) == 'show') cycle
      call read_history(run, record, quantity, told, error)
      if (allocated(error)) return
      curve%quantity = [curve%quantity, quantity]
    end do
    if (size(curve%quantity) == 0) then
      call fail(error, DECK_ERROR, 'TPLOt has no records', curve%place, &
                'after END put records '//USAGE//'; close them with a blank record')
      return
    end if
    do i = 1, size(run%model%curve)
      if (run%model%curve(i)%name /= 'tplot') cycle
      ! There is one file for all TPLOt commands.
      run%model%curve(i)%quantity = [run%model%curve(i)%quantity, curve%quantity]
      return
    end do
    run%model%curve = [run%model%curve, curve]
  end subroutine read_tplot

  subroutine read_history(run, record, quantity, told, error)
    type(run_t), intent(in) :: run
    type(record_t), intent(in) :: record
    type(quantity_t), intent(out) :: quantity
    logical, intent(inout) :: told !! a warning about numbers of a mesh file was issued
    type(error_t), allocatable, intent(out) :: error
    integer :: i, node
    real(wp) :: x(3)
    logical, allocatable :: on(:)

    call check_count(record, 3, 6, USAGE, error)
    if (allocated(error)) return
    select case (record%key(1))
    case ('disp')
      quantity%id = Q_DISP
    case ('reac')
      quantity%id = Q_NODAL
    case default
      call fail(error, DECK_ERROR, "unknown quantity '"//record%text(1)//"' of TPLOt", &
                record%place(1), USAGE//'; for stresses use CURVe with STREss; the data after ' &
                //'END follow in the order in which the commands run')
      return
    end select
    call get_integer(run%deck, record, 2, node, error, 0)
    if (allocated(error)) return
    call get_integer(run%deck, record, 3, quantity%component, error)
    if (allocated(error)) return
    do i = 1, 3
      call get_real(run%deck, record, 3 + i, x(i), error, 0.0_wp)
      if (allocated(error)) return
    end do
    if (node > 0) then
      call warn_number(run%model%mesh, node, record%place(2), told)
    else if (node == 0) then
      call nearest_nodes(run%model%mesh, x, no_rigid=.false., on=on)
      node = findloc(on, .true., 1) ! the first of several
      call check_near(run%model%mesh, x, node, record%place(min(4, record%n)), error)
      if (allocated(error)) return
      call warn_between(run%model%mesh, on, .false., record%place(min(4, record%n)))
    end if
    if (node < 1 .or. node > run%model%mesh%nnode) then
      call fail(error, DECK_ERROR, 'the mesh has no node '//to_text(node), record%place(2), &
                'nodes are numbered from 1 to '//to_text(run%model%mesh%nnode))
    else if (.not. run%model%mesh%used(node)) then
      call fail(error, DECK_ERROR, 'node '//to_text(node)//' belongs to no element', &
                record%place(2))
    else if (quantity%component < 1 .or. quantity%component > 3) then
      call fail(error, DECK_ERROR, 'expected direction 1, 2 or 3, found ' &
                //to_text(quantity%component), record%place(3), USAGE)
    end if
    quantity%node = [node]
    quantity%column = merge('disp', 'reac', quantity%id == Q_DISP)//'_'//to_text(node)//'_' &
                      //to_text(quantity%component)
    quantity%place = record%place(1)
    if (quantity%id == Q_NODAL .and. .not. allocated(error)) then
      call warn_part_of_rigid(run%model%mesh, quantity)
    end if
  end subroutine read_history

end module command_tplot
