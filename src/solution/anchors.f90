!> Anchors: springs that resist those rigid motions of bodies which contact resists only weakly.
!!
!! Let du be the displacement since the start of the step. The anchor of the motion v exerts the
!! force D v (v.D du), where the diagonal matrix D contains the mean stiffness of each node, and v.D
!! v = 1. The anchor is as stiff as the body itself, and resists no motion that is D-orthogonal to
!! v.
module anchors
  use base_kinds, only: wp
  use csr, only: block_matrix_t, diagonal_block
  use rigid_modes, only: free_body_t, rigid_motion
  implicit none
  private
  public :: anchors_t, set_anchors, anchor_force, find_load, node_stiffness, rigid_field

  !> A weak motion gets no anchor if less than this fraction of it remains after its components
  !! along the released motions, which are no longer anchored (stabilisation), and along the motions
  !! that already have an anchor have been subtracted.
  real(wp), parameter :: LEFT = 0.2_wp

  type :: anchors_t
    real(wp), allocatable :: dv(:, :, :) !! (3, nnode, n) D v; not allocated: there are none
    real(wp), allocatable :: motion(:, :, :) !! (6, body, n) coefficients of v
  end type anchors_t

contains

  !> Set anchors for the weak motions that have not been released.
  subroutine set_anchors(body, weak, released, eq, x, k, anchors)
    type(free_body_t), intent(in) :: body(:)
    real(wp), intent(in) :: weak(:, :, :)     !! (6, body, n) weak motions, v.D v = 1
    real(wp), intent(in) :: released(:, :, :) !! (6, body, m) motions that are no longer anchored
    integer, intent(in) :: eq(:, :)           !! (3, nnode) equation numbers, 0: prescribed
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) positions [L]
    type(block_matrix_t), intent(in) :: k     !! tangent
    type(anchors_t), intent(out) :: anchors
    real(wp), allocatable :: v(:, :), dv(:, :, :)
    real(wp) :: c(6, size(body), size(weak, 3) + size(released, 3)), length
    integer :: first, i, j, m, pass

    if (size(weak, 3) == 0) return
    allocate (v(3, size(x, 2)), dv(3, size(x, 2), size(c, 3)))
    c(:, :, :size(released, 3)) = released
    c(:, :, size(released, 3) + 1:) = weak
    first = 1
    m = 0
    do i = 1, size(c, 3)    ! Gram and Schmidt, released motions first
      do pass = 1, 2
        call rigid_field(body, c(:, :, i), eq, x, v)
        do j = 1, m
          c(:, :, i) = c(:, :, i) - sum(dv(:, :, j)*v)*c(:, :, j)
        end do
      end do
      call rigid_field(body, c(:, :, i), eq, x, v)
      call weigh(body, k, v)
      dv(:, :, m + 1) = v
      call rigid_field(body, c(:, :, i), eq, x, v)
      length = sqrt(sum(v*dv(:, :, m + 1)))
      if (i > size(released, 3)) then
        if (.not. length > LEFT) cycle
      else
        if (.not. length > 0.0_wp) cycle
        first = m + 2
      end if
      m = m + 1
      c(:, :, m) = c(:, :, i)/length
      dv(:, :, m) = dv(:, :, m)/length
    end do
    if (m < first) return
    allocate (anchors%dv, source=dv(:, :, first:m))
    allocate (anchors%motion, source=c(:, :, first:m))
  end subroutine set_anchors

  !> Add the forces of the anchors to internal forces.
  subroutine anchor_force(anchors, du, f)
    type(anchors_t), intent(in) :: anchors
    real(wp), intent(in) :: du(:, :)     !! (3, nnode) displacement since the start of the step [L]
    real(wp), intent(inout) :: f(:, :)   !! (3, nnode) [F]
    integer :: i

    if (.not. allocated(anchors%dv)) return
    do i = 1, size(anchors%dv, 3)
      f = f + sum(anchors%dv(:, :, i)*du)*anchors%dv(:, :, i)
    end do
  end subroutine anchor_force

  !> Find the motion v along which the anchors bear a load, with v.D v = 1, and the load itself: the
  !! largest resultant force on a body, or the work of the anchors in this motion divided by the
  !! largest displacement (the moment divided by the size of the body), whichever is larger. The
  !! anchor of a rotation has a resultant force if the centre of the rotation is not that of the
  !! stiffness D.
  subroutine find_load(anchors, body, eq, x, du, motion, load)
    type(anchors_t), intent(in) :: anchors
    type(free_body_t), intent(in) :: body(:)
    integer, intent(in) :: eq(:, :)           !! (3, nnode)
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) [L]
    real(wp), intent(in) :: du(:, :) !! (3, nnode) displacement since the start of the step [L]
    real(wp), intent(out) :: motion(:, :)     !! (6, body)
    real(wp), intent(out) :: load             !! [F]
    real(wp), allocatable :: v(:, :)
    real(wp) :: q, total
    integer :: b, i

    motion = 0.0_wp
    load = 0.0_wp
    if (.not. allocated(anchors%dv)) return
    total = 0.0_wp
    do i = 1, size(anchors%dv, 3)
      q = sum(anchors%dv(:, :, i)*du)
      motion = motion + q*anchors%motion(:, :, i)
      total = total + q**2
    end do
    if (.not. total > 0.0_wp) return
    motion = motion/sqrt(total)
    allocate (v(3, size(x, 2)))
    call rigid_field(body, motion, eq, x, v)
    load = sqrt(total/maxval(sum(v**2, 1)))
    v = 0.0_wp
    call anchor_force(anchors, du, v)
    do b = 1, size(body)
      load = max(load, norm2(sum(v(:, body(b)%node), 2)))
    end do
  end subroutine find_load

  !> Find the displacements of all nodes in rigid motions of the bodies.
  pure subroutine rigid_field(body, c, eq, x, v)
    type(free_body_t), intent(in) :: body(:)
    real(wp), intent(in) :: c(:, :)           !! (6, body)
    integer, intent(in) :: eq(:, :)           !! (3, nnode)
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) [L]
    real(wp), intent(out) :: v(:, :)          !! (3, nnode)
    integer :: b

    v = 0.0_wp
    do b = 1, size(body)
      v(:, body(b)%node) = rigid_motion(body(b), c(:, b), eq, x)
    end do
  end subroutine rigid_field

  !> Multiply by D.
  pure subroutine weigh(body, k, v)
    type(free_body_t), intent(in) :: body(:)
    type(block_matrix_t), intent(in) :: k
    real(wp), intent(inout) :: v(:, :)        !! (3, nnode)
    integer :: b, i

    do b = 1, size(body)
      do i = 1, size(body(b)%node)
        associate (n => body(b)%node(i))
          v(:, n) = node_stiffness(k, n)*v(:, n)
        end associate
      end do
    end do
  end subroutine weigh

  !> Mean stiffness of a node [F/L].
  pure real(wp) function node_stiffness(k, n) result(stiffness)
    type(block_matrix_t), intent(in) :: k
    integer, intent(in) :: n
    real(wp) :: block(3, 3)

    block = diagonal_block(k, n)
    stiffness = abs(block(1, 1) + block(2, 2) + block(3, 3))/3.0_wp
  end function node_stiffness

end module anchors
