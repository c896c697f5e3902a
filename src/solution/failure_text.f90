!> Names the elements and dofs that made an iteration of Newton's method fail.
module failure_text
  use assembly, only: sweep_t
  use base_kinds, only: wp
  use base_text, only: to_text
  use dof_map, only: dof_name
  use mesh, only: is_rigid
  use model, only: model_t, state_t
  use rigid_modes, only: free_body_t, find_free_bodies, motion_text
  implicit none
  private
  public :: element_name, name_element, name_singularity

  integer, parameter :: MOST = 4       !! largest number of dofs, and of bodies, in a message

contains

  !> Name the element that failed, such as: `Q1 element 3 of 'cube' is inverted`.
  function name_element(model, sweep) result(text)
    type(model_t), intent(in) :: model
    type(sweep_t), intent(in) :: sweep
    character(:), allocatable :: text

    text = element_name(model, sweep%block, sweep%elem)//' is inverted'
    if (model%mesh%block(sweep%block)%row%nmode > 0) then
      text = text//', or its enhanced modes are singular'
    end if
  end function name_element

  !> Type, number and body of an element, such as: `Q1 element 3 of 'cube'`.
  function element_name(model, b, e) result(text)
    type(model_t), intent(in) :: model
    integer, intent(in) :: b, e !! block, and element in the block
    character(:), allocatable :: text

    associate (block => model%mesh%block(b))
      text = trim(block%name)//' element '//to_text(block%number(e))
      if (block%body > 0) text = text//" of '"//model%mesh%body(block%body)%name//"'"
    end associate
  end function element_name

  !> Name a singularity and the bodies that may have caused it, such as: `the tangent is singular at
  !! dof uy of node 3; nothing holds body 'ball', which can move along x, turn about z`.
  !! `hopeless` is true if there is a body that neither supports nor contact will ever hold.
  subroutine name_singularity(model, state, null, text, hopeless)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: null(:) !! equations whose pivot vanished
    character(:), allocatable, intent(out) :: text
    logical, intent(out) :: hopeless
    type(free_body_t), allocatable :: body(:)
    integer :: b, i, named

    text = 'the tangent is singular'
    do i = 1, min(size(null), MOST)
      text = text//trim(merge(',  ', ' at', i > 1))//' '//dof_name(model%eq, null(i))
    end do
    if (size(null) > MOST) text = text//' and '//to_text(size(null) - MOST)//' more'
    call find_free_bodies(model, model%mesh%xr + state%u, body)
    if (state%dynamics%on .and. state%dt > 0.0_wp) then ! inertia holds bodies with a mass
      body = pack(body, [(.not. has_mass(model, body(b)%node), b=1, size(body))])
    end if
    hopeless = .not. all(body%in_contact)
    named = 0
    do b = 1, size(body)
      if (body(b)%in_contact .and. hopeless) cycle
      named = named + 1
      if (named > MOST) cycle
      if (body(b)%in_contact) then
        text = text//'; only contact can hold '
      else
        text = text//'; nothing holds '
      end if
      text = text//body(b)%name//', which can '//motion_text(body(b)%motion(:, :body(b)%nmotion))
    end do
    if (named > MOST) text = text//'; and '//to_text(named - MOST)//' more bodies'
  end subroutine name_singularity

  !> Does any element of a body have a density?
  pure logical function has_mass(model, node)
    type(model_t), intent(in) :: model
    integer, intent(in) :: node(:) !! the nodes of the body
    integer :: b

    has_mass = .false.
    do b = 1, size(model%mesh%block)
      associate (block => model%mesh%block(b))
        if (is_rigid(block)) cycle
        if (.not. model%material(block%material)%density > 0.0_wp) cycle
        has_mass = has_mass .or. any(node == block%conn(1, 1))
      end associate
    end do
  end function has_mass

end module failure_text
