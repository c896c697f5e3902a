!> Names the elements and dofs that caused a failed iteration of Newton's method.
module failure_text
  use assembly, only: sweep_t
  use base_kinds, only: wp
  use base_text, only: to_text
  use dof_map, only: dof_name
  use mesh, only: solid_nodes
  use model, only: model_t
  implicit none
  private
  public :: name_element, name_singularity

  integer, parameter :: MOST = 4       !! largest number of dofs that are named

contains

  !> Name the element that failed, such as: `Q1 element 3 of 'cube' is inverted`.
  function name_element(model, sweep) result(text)
    type(model_t), intent(in) :: model
    type(sweep_t), intent(in) :: sweep
    character(:), allocatable :: text

    associate (block => model%mesh%block(sweep%block))
      text = trim(block%name)//' element '//to_text(block%number(sweep%elem))
      if (block%body > 0) text = text//" of '"//model%mesh%body(block%body)%name//"'"
      text = text//' is inverted'
      if (block%row%nmode > 0) text = text//', or its enhanced modes are singular'
    end associate
  end function name_element

  !> Name a singularity, such as: `the tangent is singular at dof uy of node 3; the model can move
  !! along x, turn about z`.
  function name_singularity(model, null) result(text)
    type(model_t), intent(in) :: model
    integer, intent(in) :: null(:) !! equations whose pivot vanished
    character(:), allocatable :: text, motions
    integer :: i

    text = 'the tangent is singular'
    do i = 1, min(size(null), MOST)
      text = text//trim(merge(',  ', ' at', i > 1))//' '//dof_name(model%eq, null(i))
    end do
    if (size(null) > MOST) text = text//' and '//to_text(size(null) - MOST)//' more'
    motions = free_motions(model)
    if (len(motions) > 0) text = text//'; the model can '//motions
  end function name_singularity

  !> Rigid motions along and about the axes that no support prevents, for a message.
  function free_motions(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    real(wp) :: x(3), centre(3), hold(6), size_of
    logical, allocatable :: solid(:)
    integer :: i, n
    character(*), parameter :: NAMES(6) = ['move along x', 'move along y', 'move along z', &
                                           'turn about x', 'turn about y', 'turn about z']

    call solid_nodes(model%mesh, solid)
    do i = 1, model%mesh%constraint%n ! slaves do not support the model
      solid(model%mesh%constraint%slave(i)) = .false.
    end do
    centre = 0.0_wp
    n = 0
    do i = 1, model%mesh%nnode
      if (.not. any(model%eq(:, i) == 0) .or. .not. solid(i)) cycle
      centre = centre + model%mesh%xr(:, i)
      n = n + 1
    end do
    if (n > 0) centre = centre/n
    size_of = maxval(maxval(model%mesh%xr, 2) - minval(model%mesh%xr, 2))
    hold = 0.0_wp
    do i = 1, model%mesh%nnode
      if (.not. solid(i)) cycle
      x = model%mesh%xr(:, i) - centre
      where (model%eq(:, i) == 0) hold(:3) = 1.0_wp
      if (model%eq(1, i) == 0) hold(5:6) = max(hold(5:6), abs([x(3), x(2)])/size_of)
      if (model%eq(2, i) == 0) hold([4, 6]) = max(hold([4, 6]), abs([x(3), x(1)])/size_of)
      if (model%eq(3, i) == 0) hold(4:5) = max(hold(4:5), abs([x(2), x(1)])/size_of)
    end do
    text = ''
    do i = 1, 6
      if (hold(i) > 1.0e-10_wp) cycle
      if (len(text) > 0) text = text//', '
      text = text//NAMES(i)
    end do
  end function free_motions

end module failure_text
