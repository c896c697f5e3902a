!> Bodies that were pushed away, because nothing resisted: a warning at the end of a run.
!!
!! In statics, a prescribed motion can push a body without sufficient supports through contact. If
!! nothing stops the body, it moves along as a rigid body and no force acts on it, although the
!! motion was probably meant to compress it. A body that a load moves does not end here: its step
!! fails (module stabilisation).
module unresisted
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use mesh, only: is_rigid
  use model, only: model_t, state_t
  use rigid_modes, only: free_body_t, find_free_bodies, rigid_motion
  use stabilisation_report, only: direction_text
  implicit none
  private
  public :: warn_unresisted

  real(wp), parameter :: TRAVEL = 1.0e-6_wp !! smaller motions, relative to the size, do not count
  !> A smaller force is due to rounding. It is relative to the force that would compress the softest
  !! material of the model by the motion.
  real(wp), parameter :: NO_FORCE = 1.0e-9_wp
  real(wp), parameter :: ALIKE = 0.5_wp    !! mean displacement, relative to the largest one, above
  !! which the motion is called a translation

contains

  !> Warn of each body that has moved along one of its free motions, although the forces of its
  !! contacts have been zero in all steps. Bodies with bonds are meant to separate, and inertia
  !! moves bodies without contact.
  subroutine warn_unresisted(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(free_body_t), allocatable :: body(:)
    real(wp) :: moved
    integer :: b

    if (size(model%contact) == 0 .or. state%dynamics%on .or. state%step == 0) return
    call find_free_bodies(model, model%mesh%xr, body)
    do b = 1, size(body)
      if (.not. body(b)%in_contact .or. body(b)%bonded) cycle
      moved = free_displacement(model, state, body(b))
      if (.not. moved > TRAVEL*body(b)%size) cycle
      if (contact_force(model, state, body(b)%node) &
          > NO_FORCE*softest(model)*body(b)%size*moved) cycle
      call warn(body(b)%name//' was pushed '//motion_of(model, state, body(b)) &
                //'and nothing resisted: no contact force acted on it in any step', &
                hint='is a support missing? FIX or MOVE holds patches; BOUN, EBOU and CBOU hold ' &
                //'nodes; another CONTact may stop the body')
    end do
  end subroutine warn_unresisted

  !> Displacement of a body along the motions that its supports permit [L].
  pure real(wp) function free_displacement(model, state, body) result(moved)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(free_body_t), intent(in) :: body
    real(wp) :: v(3, size(body%node))
    integer :: i

    moved = 0.0_wp
    do i = 1, body%nmotion
      v = rigid_motion(body, body%motion(:, i), model%eq, model%mesh%xr)
      moved = max(moved, abs(sum(v*state%u(:, body%node)))/sum(v**2))
    end do
  end function free_displacement

  !> The largest force of the contacts of a body over all steps [F]; huge if the body takes part in
  !! a self-contact, where action and reaction cancel in the sum.
  pure real(wp) function contact_force(model, state, node) result(force)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: node(:)       !! nodes of the body
    logical :: inside(model%mesh%nnode)
    integer :: c, k

    inside = .false.
    inside(node) = .true.
    force = 0.0_wp
    do c = 1, size(model%contact)
      do k = 1, 2
        if (.not. any(inside(model%contact(c)%side(k)%node))) cycle
        force = max(force, state%contact(c)%largest_force)
        if (model%contact(c)%self) force = huge(force)
      end do
    end do
  end function contact_force

  !> The smallest Young's modulus of the deformable bodies [F/L^2].
  pure real(wp) function softest(model) result(young)
    type(model_t), intent(in) :: model
    integer :: b

    young = huge(young)
    do b = 1, size(model%mesh%block)
      if (is_rigid(model%mesh%block(b))) cycle
      associate (material => model%material(model%mesh%block(b)%material))
        young = min(young, material%row%stiffness(material%prop))
      end associate
    end do
  end function softest

  !> The motion of a body as text, with a blank at its end.
  function motion_of(model, state, body) result(text)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(free_body_t), intent(in) :: body
    character(:), allocatable :: text
    real(wp) :: u(3, size(body%node)), mean(3), largest

    u = state%u(:, body%node)
    where (model%eq(:, body%node) == 0) u = 0.0_wp
    mean = sum(u, 2)/size(u, 2)
    largest = maxval(norm2(u, 1))
    text = 'by up to '//to_text(largest, 3)//', '
    if (norm2(mean) > ALIKE*largest) text = 'by '//to_text(norm2(mean), 3)//' along ' &
                                            //direction_text(mean)//', '
  end function motion_of

end module unresisted
