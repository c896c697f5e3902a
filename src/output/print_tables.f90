!> FEAP's printed tables DISPlacements, REACtions and STREss, written to `<stem>.out`.
module print_tables
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_text, only: to_text
  use byte_file, only: byte_file_t, write_text, flush_bytes
  use mesh, only: is_rigid, mark_rigid
  use model, only: model_t, state_t
  use point_values, only: reactions_at
  use solid_recover, only: recovered_t, recover
  use stress_projection, only: project_stress
  implicit none
  private
  public :: print_displacements, print_reactions, print_stresses, print_nodal_stresses

  character(*), parameter :: LF = new_line('a')

contains

  !> Print coordinates and displacements of nodes.
  subroutine print_displacements(file, model, state, node, error, before)
    type(byte_file_t), intent(in) :: file
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: node(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: before !! time of the state, see heading
    character(:), allocatable :: text
    integer :: i

    text = heading('N o d a l   D i s p l a c e m e n t s', model, state, before)//LF// &
           '    Node        1 Coord        2 Coord        3 Coord        1 Displ        2 Displ'// &
           '        3 Displ'//LF
    call write_text(file, text, error)
    do i = 1, size(node)
      if (allocated(error)) return
      call write_text(file, row([node(i)], [model%mesh%xr(:, node(i)), state%u(:, node(i))]), error)
    end do
    if (.not. allocated(error)) call flush_bytes(file, error)
  end subroutine print_displacements

  !> Print reactions as FEAP defines them (nodal forces are not subtracted), their sums over the
  !! printed nodes and over all nodes, the sums of their magnitudes, and the measure of work u.R.
  subroutine print_reactions(file, model, state, factor, node, error, before)
    type(byte_file_t), intent(in) :: file
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: factor(:) !! load factors with which state%reaction was formed
    integer, intent(in) :: node(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: before !! time of the state, see heading
    character(:), allocatable :: text
    real(wp), allocatable :: r(:, :)
    logical, allocatable :: rigid(:)
    integer :: i

    allocate (r(3, model%mesh%nnode))
    r = reactions_at(model, state, factor, [(i, i=1, model%mesh%nnode)])
    text = heading('N o d a l    R e a c t i o n s', model, state, before)//LF// &
           '    Node          1 dof          2 dof          3 dof'//LF
    call write_text(file, text, error)
    do i = 1, size(node)
      if (allocated(error)) return
      call write_text(file, row([node(i)], r(:, node(i))), error)
    end do
    if (allocated(error)) return
    text = LF//' Pr.Sum '//numbers(sum(r(:, node), 2))//LF// &
           '   Sum  '//numbers(sum(r, 2))//LF// &
           '  |Sum| '//numbers(sum(abs(r), 2))//LF// &
           '   Energy: Displacements * Reactions = '//numbers([sum(state%u*r)])//LF
    if (any(abs(r(:, node) - state%reaction(:, node)) > 0.0_wp)) then
      text = text//'   Nodal forces (FORCe, EFORce, CFORce, CSURface) are included, as in FEAP'//LF
    end if
    call mark_rigid(model%mesh, rigid)
    if (any(rigid(node))) then
      text = text//'   Values at single nodes of rigid patches have no meaning, only their sum'//LF
    end if
    call write_text(file, text, error)
    if (.not. allocated(error)) call flush_bytes(file, error)
  end subroutine print_reactions

  !> Print Cauchy stresses at the integration points of the elements first, first+step, ... last.
  subroutine print_stresses(file, model, state, first, last, step, error, before)
    type(byte_file_t), intent(in) :: file
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: first, last, step !! element numbers given by the user
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: before !! time of the state, see heading
    type(recovered_t), allocatable :: point(:)
    integer :: b, e, number, q
    logical :: ok

    call write_text(file, heading('E l e m e n t   S t r e s s e s', model, state, before)//LF &
                    //'    Elmt    Mate        1 Coord        2 Coord        3 Coord' &
                    //'      11-stress      22-stress      33-stress      12-stress' &
                    //'      23-stress      ' &
                    //'31-stress'//'          Mises'//LF, error)
    do b = 1, size(model%mesh%block)
      if (is_rigid(model%mesh%block(b))) cycle
      associate (block => model%mesh%block(b), set => model%material(model%mesh%block(b)%material))
        do e = 1, block%nelem
          number = block%number(e)
          if (number < first .or. number > last) cycle
          if (modulo(number - first, max(step, 1)) /= 0) cycle
          allocate (point(block%basis(block%ibasis(e))%nq))
          call recover(block%basis(block%ibasis(e)), set%row, set%prop, &
                       model%mesh%xr(:, block%conn(:, e)), state%u(:, block%conn(:, e)), &
                       state%history(b)%iter(:, e), point, ok)
          do q = 1, size(point)
            if (allocated(error)) return
            call write_text(file, row([number, set%number], &
                                      [point(q)%xc, point(q)%sig, point(q)%mises]), error)
          end do
          deallocate (point)
        end do
      end associate
    end do
    if (.not. allocated(error)) call flush_bytes(file, error)
  end subroutine print_stresses

  !> Print smoothed Cauchy stresses at nodes (STRE,NODE).
  subroutine print_nodal_stresses(file, model, state, node, error, before)
    type(byte_file_t), intent(in) :: file
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: node(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: before !! time of the state, see heading
    real(wp), allocatable :: stress(:, :), mises(:, :)
    integer :: i

    allocate (stress(6, model%mesh%nnode), mises(1, model%mesh%nnode))
    call project_stress(model, state, stress, mises)
    call write_text(file, heading('N o d a l   P r o j e c t i o n s', model, state, before)//LF &
                    //'    Node      11-stress      22-stress      33-stress      12-stress      ' &
                    //'23-stress'//'      31-stress          Mises'//LF, error)
    do i = 1, size(node)
      if (allocated(error)) return
      call write_text(file, row([node(i)], [stress(:, node(i)), mises(1, node(i))]), error)
    end do
    if (.not. allocated(error)) call flush_bytes(file, error)
  end subroutine print_nodal_stresses

  !> Heading of a table: title, name of the table, time and load factors.
  function heading(name, model, state, before) result(text)
    character(*), intent(in) :: name
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in), optional :: before !! time of the state if nothing has been solved in the
    !! step to which the time and the load factors belong [T]
    character(:), allocatable :: text
    character(40) :: line

    text = LF
    if (allocated(model%title)) text = text//'  '//trim(model%title)//LF//LF
    write (line, '(a, es18.8e3)') '     Time', state%time
    text = text//'     '//name//trim(line)//LF
    if (size(state%factor) > 0) text = text//'     Prop. Ld.'//numbers(state%factor)//LF
    if (.not. present(before)) return
    text = text//'     Nothing has been solved at this time: the table shows the state of time ' &
           //to_text(before)//LF
  end function heading

  function row(label, values) result(line)
    integer, intent(in) :: label(:)
    real(wp), intent(in) :: values(:)
    character(:), allocatable :: line
    character(8*size(label)) :: labels

    write (labels, '(*(i8))') label
    line = labels//numbers(values)//LF
  end function row

  pure function numbers(values) result(line)
    real(wp), intent(in) :: values(:)
    character(15*size(values)) :: line

    write (line, '(*(es15.6e3))') values
  end function numbers

end module print_tables
