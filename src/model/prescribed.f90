!> Prescribed displacements: DISP values and rigid motions at the current load factors.
module prescribed
  use base_kinds, only: wp
  use boundary, only: motion_t
  use load_curve, only: load_factor
  use model, only: model_t
  use tensor, only: cross
  implicit none
  private
  public :: prescribed_values, prescribed_rates, to_prescribed

  real(wp), parameter :: TURN = 1.0e-4_wp !! [rad] step to both sides for the difference quotient of
  !! a rotation

contains

  !> Find the displacement of every prescribed dof; it is zero elsewhere. The rotations of a node
  !! act, in the order of the deck, on its reference position plus its DISP values; then the
  !! translations of the node are added.
  subroutine prescribed_values(model, factor, up)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: factor(:)  !! (ntable)
    real(wp), intent(out) :: up(:, :)  !! (3, nnode) [L]
    integer :: i, m, n

    up = 0.0_wp
    do n = 1, model%mesh%nnode
      do i = 1, 3
        if (model%bc%fixed(i, n) /= 0 .and. abs(model%bc%value(i, n)) > 0.0_wp) then
          up(i, n) = model%bc%value(i, n)*load_factor(factor, model%bc%table(i, n))
        end if
      end do
    end do
    do m = 1, size(model%bc%motion)
      if (model%bc%motion(m)%rotates) then
        call rotate(model%bc%motion(m), model%mesh%xr, &
                    load_factor(factor, model%bc%motion(m)%table), up)
      end if
    end do
    do m = 1, size(model%bc%motion)
      if (.not. model%bc%motion(m)%rotates) then
        call translate(model%bc%motion(m), load_factor(factor, model%bc%motion(m)%table), up)
      end if
    end do
  end subroutine prescribed_values

  !> Find the increment from u to the prescribed displacements at `factor`. It is zero at free dofs,
  !! and at slaves, which follow their masters.
  subroutine to_prescribed(model, factor, u, du)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: factor(:)  !! (ntable)
    real(wp), intent(in) :: u(:, :)    !! (3, nnode) [L]
    real(wp), intent(out) :: du(:, :)  !! (3, nnode) [L]

    call prescribed_values(model, factor, du)
    du = du - u
    call leave_free(model, du)
  end subroutine to_prescribed

  !> Find the derivative of the prescribed displacements with respect to time from the derivatives
  !! of the factors; it is zero elsewhere.
  subroutine prescribed_rates(model, factor, slope, rate)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: factor(:)   !! (ntable)
    real(wp), intent(in) :: slope(:)    !! (ntable) derivatives of the factors
    real(wp), intent(out) :: rate(:, :) !! (3, nnode)
    real(wp), allocatable :: back(:, :)
    real(wp) :: h
    integer :: m

    rate = 0.0_wp
    if (.not. any(abs(slope) > 0.0_wp)) return
    h = 0.0_wp
    do m = 1, size(model%bc%motion)
      if (model%bc%motion(m)%rotates) h = max(h, abs(model%bc%motion(m)%angle))
    end do
    if (h > 0.0_wp) then
      h = TURN/(h*sum(abs(slope)))
      allocate (back, mold=rate)
      call prescribed_values(model, factor - h*slope, back)
      call prescribed_values(model, factor + h*slope, rate)
      rate = (rate - back)/(2*h)
    else
      call prescribed_values(model, slope, rate) ! displacements are linear in the factors
    end if
    call leave_free(model, rate)
  end subroutine prescribed_rates

  !> Set a vector to zero at free dofs, unused nodes and slaves.
  pure subroutine leave_free(model, v)
    type(model_t), intent(in) :: model
    real(wp), intent(inout) :: v(:, :) !! (3, nnode)
    integer :: i, n

    do n = 1, model%mesh%nnode
      do i = 1, 3
        if (model%eq(i, n) /= 0 .or. .not. model%mesh%used(n)) v(i, n) = 0.0_wp
      end do
    end do
    do i = 1, model%mesh%constraint%n
      v(:, model%mesh%constraint%slave(i)) = 0.0_wp
    end do
  end subroutine leave_free

  subroutine translate(motion, factor, up)
    type(motion_t), intent(in) :: motion
    real(wp), intent(in) :: factor
    real(wp), intent(inout) :: up(:, :)
    integer :: j, n

    do j = 1, size(motion%node)
      n = motion%node(j)
      where (motion%acts) up(:, n) = up(:, n) + factor*motion%vector
    end do
  end subroutine translate

  !> Rotate by Rodrigues' formula about the axis through motion%vector.
  subroutine rotate(motion, xr, factor, up)
    type(motion_t), intent(in) :: motion
    real(wp), intent(in) :: xr(:, :)  !! (3, nnode)
    real(wp), intent(in) :: factor
    real(wp), intent(inout) :: up(:, :)
    real(wp) :: c, s, d(3), x(3)
    integer :: j, n

    c = 2.0_wp*sin(0.5_wp*factor*motion%angle)**2  ! 1 - cos, without cancellation
    s = sin(factor*motion%angle)
    do j = 1, size(motion%node)
      n = motion%node(j)
      x = xr(:, n) + up(:, n) - motion%vector
      d = cross(motion%axis, x)
      up(:, n) = up(:, n) + s*d + c*cross(motion%axis, d)
    end do
  end subroutine rotate

end module prescribed
