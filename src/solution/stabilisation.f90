!> Bodies without sufficient supports that contact does not hold yet, or does not hold in all
!! directions.
!!
!! The rigid motions v of such bodies are sorted by their stiffness v.K v/v.D v, where K is the
!! tangent and the diagonal matrix D contains the mean stiffness of each node. For bodies much
!! stiffer than the surfaces that hold them, D is reduced (find_softness).
!!
!! 1. If a translation has no stiffness (less than NO_STIFFNESS) and a load acts along it, the body
!!    "flies": it is moved in that direction, or the shortest way to a surface whose friction can
!!    hold it (module approach), up to the nearest other surface and then farther, by
!!    distances that begin with a millionth of the width of an element and grow. If several bodies
!!    move, each contact limits the move by its gap and the relative velocity of its surfaces. As
!!    soon as contact resists, Newton's iteration continues from there. If the body meets no
!!    surface, the step fails.
!! 2. If a motion has little stiffness (less than WEAK, or a negative one), an anchor (module
!!    anchors) resists displacements along this motion, measured from the start of the step. An
!!    example is a ball that can turn and slide on a plate without friction. If the anchor bears
!!    more than the fraction NO_LOAD of all loads when the iteration converges, the motion is
!!    released, and the iteration continues.
!! 3. Springs with the stiffness SPRING D are added to the tangent, but not to the residual. They
!!    make every system regular. An increment whose energy is mainly that of the springs is
!!    shortened to the distances of item 1.
!!
!! None of this is done if the tangent resists every motion. If all contacts have friction and the
!! tangent of an iterate resists every motion, none of it is done in the rest of the step either,
!! unless a motion has no stiffness at all: where all points slip in a later iterate, the stiffness
!! is small, but Newton's iteration returns without anchors. This does not apply once a body was
!! moved in the direction of its load, because it may slide on before friction holds it. All limits
!! are relative.
!! Theory: doc/theory/contact.md.
module stabilisation
  use anchors, only: anchors_t, find_load, node_stiffness, rigid_field
  use base_kinds, only: wp
  use base_comm, only: is_root
  use contact_assembly, only: friction_acts
  use contact_pair, only: contact_t
  use csr, only: block_matrix_t, block_position, multiply
  use lapack, only: dsyev
  use model, only: model_t, state_t
  use rigid_modes, only: free_body_t, find_free_bodies, is_within_body, find_motions, &
                         rigid_motion, null_vectors
  use surface_distance, only: find_distance
  implicit none
  private
  public :: stabilisation_t, begin_stabilisation, end_stabilisation, find_unheld, use_springs, &
            find_flight, release_loaded, find_reach, add_springs, remove_springs, spring_energy, &
            note_move, is_lost, is_restless

  real(wp), parameter :: SPRING = 1.0e-10_wp   !! stiffness of the springs, relative to the node's
  real(wp), parameter :: NO_STIFFNESS = 1.0e-9_wp
  real(wp), parameter :: WEAK = 1.0e-4_wp
  real(wp), parameter :: MUCH = 30.0_wp        !! a body this many times as stiff as a surface is
  !! compared with the surface
  real(wp), parameter :: NO_LOAD = 2.0e-2_wp   !! largest force of an anchor, relative to all loads
  real(wp), parameter :: PURE = 1.0e-6_wp      !! largest part of a rotation in a translation
  real(wp), parameter :: UNLOADED = 1.0e-6_wp  !! a smaller force, relative to the largest nodal
  !! force, does not count as a load
  real(wp), parameter :: SLOPE = sqrt(NO_STIFFNESS) !! a smaller force on a body that contact
  !! touches, relative to all loads, is the push of a surface that is not quite level
  real(wp), parameter :: FIRST = 1.0e-6_wp     !! first move of a body that touches, relative to the
  !! width of an element
  real(wp), parameter :: GROWTH = 4.0_wp       !! length of a move, relative to the previous one
  real(wp), parameter :: LONGEST = 0.25_wp     !! longest move, relative to the smaller of the width
  !! of an element and DEPTh
  real(wp), parameter :: FAR = 2.0_wp          !! a body that has moved this far, relative to the
  !! model, is lost
  integer, parameter :: MOST_MOVES = 100       !! largest number of moves in a step

  type :: stabilisation_t
    logical :: known = .false.           !! `body` is known
    type(free_body_t), allocatable :: body(:) !! bodies that only contact can hold
    logical :: active = .false.          !! the tangent did not resist some motion
    logical :: held = .false.            !! since then, in this step, friction resisted every motion
    logical :: fell = .false.            !! a body was moved in the direction of its load
    logical :: springs = .false.         !! the tangent of this iteration has springs
    logical :: used = .false.            !! an iteration of this step had springs
    integer :: moves = 0                 !! number of moves in this step
    integer, allocatable :: at_contact(:) !! (contact) number of consecutive moves that began where
    !! its surfaces touched
    real(wp), allocatable :: shift(:, :) !! (3, body) sum of the moves of the step [L]
    !> (6, body, m) motions that nothing resists: m orthonormal vectors of 6*body coefficients.
    real(wp), allocatable :: unheld(:, :, :)
    real(wp), allocatable :: weak(:, :, :) !! (6, body, m) motions of little stiffness, v.D v = 1
    real(wp), allocatable :: released(:, :, :) !! (6, body, m) motions that are no longer anchored
    real(wp) :: energy = 0.0_wp          !! energy of the anchors, summed over the steps [F L]
    real(wp) :: work = 0.0_wp            !! work of loads and supports in the same steps [F L]
    real(wp), allocatable :: kept(:, :, :) !! (3, 3, node) blocks without the springs
    logical :: warned = .false.          !! the warning about free motions was issued
    real(wp) :: warned_share = 0.0_wp    !! share of anchors in the last warning
  end type stabilisation_t

contains

  !> Begin a step.
  subroutine begin_stabilisation(hold, model)
    type(stabilisation_t), intent(inout) :: hold
    type(model_t), intent(in) :: model
    type(free_body_t), allocatable :: body(:)
    integer, allocatable :: list(:)
    integer :: b

    if (.not. hold%known) then
      allocate (hold%body(0))
      if (size(model%contact) > 0) then
        call find_free_bodies(model, model%mesh%xr, body)
        list = pack([(b, b=1, size(body))], body%in_contact .and. .not. body%bonded)
        deallocate (hold%body)
        allocate (hold%body(size(list)))
        do b = 1, size(list)
          hold%body(b) = body(list(b))
        end do
      end if
      allocate (hold%at_contact(size(model%contact)))
      allocate (hold%shift(3, size(hold%body)), hold%unheld(6, size(hold%body), 0), &
                hold%weak(6, size(hold%body), 0))
      hold%known = .true.
    end if
    hold%used = .false.
    hold%held = .false.
    hold%moves = 0
    hold%at_contact = 0
    hold%shift = 0.0_wp
    if (allocated(hold%released)) deallocate (hold%released)
    allocate (hold%released(6, size(hold%body), 0))
  end subroutine begin_stabilisation

  !> End an accepted step. If friction held all bodies when the step converged, and no body was
  !! moved, the next step begins as with sufficient supports, so that its displacements may be
  !! predicted.
  pure subroutine end_stabilisation(hold)
    type(stabilisation_t), intent(inout) :: hold

    if (hold%held .and. hold%moves == 0) hold%active = .false.
  end subroutine end_stabilisation

  !> Find the rigid motions that supports do not prevent and the tangent resists only weakly
  !! (`weak`) or not at all (`unheld`). With inertia there are none, because inertia resists every
  !! motion.
  subroutine find_unheld(hold, model, state, k, secant)
    type(stabilisation_t), intent(inout) :: hold
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(block_matrix_t), intent(in) :: k
    logical, intent(in) :: secant        !! the tangent has secants of friction
    real(wp), allocatable :: x(:, :), v(:, :, :), kv(:, :), c(:, :, :), g(:, :), d(:, :), t(:, :)
    real(wp), allocatable :: kernel(:, :), q(:, :), soft(:)
    integer, allocatable :: owner(:)
    integer :: b, i, j, m, n, s

    hold%springs = .false.
    if (size(hold%weak, 3) > 0) then
      deallocate (hold%unheld, hold%weak)
      allocate (hold%unheld(6, size(hold%body), 0), hold%weak(6, size(hold%body), 0))
    end if
    if (size(hold%body) == 0 .or. state%dynamics%on) return
    allocate (x, source=model%mesh%xr + state%u)
    m = 0
    do b = 1, size(hold%body)
      call find_motions(model%eq, x, hold%body(b))
      m = m + hold%body(b)%nmotion
    end do
    if (m == 0) return
    allocate (v(3, model%mesh%nnode, m), kv(3, model%mesh%nnode), owner(m))
    allocate (c(6, size(hold%body), m), source=0.0_wp)
    v = 0.0_wp
    m = 0
    do b = 1, size(hold%body)
      do i = 1, hold%body(b)%nmotion
        m = m + 1
        owner(m) = b
        c(:, b, m) = hold%body(b)%motion(:, i)
        v(:, hold%body(b)%node, m) = rigid_motion(hold%body(b), c(:, b, m), model%eq, x)
      end do
    end do
    allocate (g(m, m), d(m, m), source=0.0_wp)
    call find_softness(hold%body, model%contact, model%eq, k, soft)
    do j = 1, m
      call multiply(k, v(:, :, j), kv)
      do i = 1, m
        g(i, j) = sum(v(:, :, i)*kv)
      end do
      do n = 1, size(hold%body(owner(j))%node)
        b = hold%body(owner(j))%node(n)
        kv(:, b) = node_stiffness(k, b)*v(:, b, j)
      end do
      do i = 1, m
        if (owner(i) /= owner(j)) cycle
        associate (node => hold%body(owner(j))%node)
          d(i, j) = soft(owner(j))*sum(v(:, node, i)*kv(:, node))
        end associate
      end do
    end do
    call inverse_root(d, t)
    g = matmul(transpose(t), matmul(0.5_wp*(g + transpose(g)), t))
    if (hold%held .or. .not. hold%active) then
      call null_vectors(g, NO_STIFFNESS, kernel)
      if (size(kernel, 2) == 0) return
      hold%active = .true.
      hold%held = .false.
    end if
    call null_vectors(g, merge(NO_STIFFNESS, WEAK, secant), kernel, or_less=.true.)
    if (size(kernel, 2) == 0) then
      hold%held = all([(friction_acts(model%contact(s), state), s=1, size(model%contact))]) .and. &
                  .not. hold%fell
      return
    end if
    hold%springs = .true.
    hold%used = .true.
    q = matmul(reshape(c, [6*size(hold%body), m]), matmul(t, kernel))
    hold%weak = reshape(q, [6, size(hold%body), size(q, 2)])
    call null_vectors(g, NO_STIFFNESS, kernel)
    if (size(kernel, 2) == 0) return
    q = matmul(reshape(c, [6*size(hold%body), m]), matmul(t, kernel))
    call orthonormalise(q)
    hold%unheld = reshape(q, [6, size(hold%body), size(q, 2)])
  end subroutine find_unheld

  !> The factor of the stiffness of each body to which the stiffness of its motions is compared. A
  !! contact cannot be stiffer than the softest surface that it has, so that a body which is much
  !! stiffer would seem to be held by nothing.
  subroutine find_softness(body, contact, eq, k, soft)
    type(free_body_t), intent(in) :: body(:)
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: eq(:, :)      !! (3, nnode) equation numbers, 0: prescribed
    type(block_matrix_t), intent(in) :: k
    real(wp), allocatable, intent(out) :: soft(:) !! (body), at most 1
    real(wp) :: least
    integer :: b, c, i

    least = huge(least)
    do c = 1, size(contact)
      do i = 1, 2
        associate (node => contact(c)%side(i)%node)
          if (any(eq(:, node) > 0)) least = min(least, mean_stiffness(k, node))
        end associate
      end do
    end do
    allocate (soft(size(body)))
    do b = 1, size(body)
      soft(b) = min(1.0_wp, MUCH*least/max(mean_stiffness(k, body(b)%node), tiny(least)))
    end do
  end subroutine find_softness

  !> Mean stiffness of some nodes [F/L].
  pure real(wp) function mean_stiffness(k, node) result(mean)
    type(block_matrix_t), intent(in) :: k
    integer, intent(in) :: node(:)
    integer :: i

    mean = 0.0_wp
    do i = 1, size(node)
      mean = mean + node_stiffness(k, node(i))/size(node)
    end do
  end function mean_stiffness

  !> Use springs because the tangent is singular although every motion seemed to be resisted. The
  !! result is false if there is no body that springs could hold.
  logical function use_springs(hold, state) result(possible)
    type(stabilisation_t), intent(inout) :: hold
    type(state_t), intent(in) :: state

    possible = .not. (hold%springs .or. state%dynamics%on) .and. size(hold%body) > 0
    if (.not. possible) return
    hold%active = .true.
    hold%springs = .true.
    hold%used = .true.
  end function use_springs

  !> T with T^T D T = 1, where D is a symmetric positive definite matrix.
  subroutine inverse_root(d, t)
    real(wp), intent(in) :: d(:, :)
    real(wp), allocatable, intent(out) :: t(:, :)
    real(wp) :: value(size(d, 1)), work(8*size(d, 1))
    integer :: i, info

    allocate (t, source=d)
    call dsyev('V', 'U', size(d, 1), t, size(d, 1), value, work, size(work), info)
    do i = 1, size(value)
      t(:, i) = t(:, i)/sqrt(max(value(i), tiny(value)))
    end do
  end subroutine inverse_root

  !> Orthonormalise columns by Gram and Schmidt, twice.
  pure subroutine orthonormalise(q)
    real(wp), intent(inout) :: q(:, :)
    integer :: i, j, pass

    do i = 1, size(q, 2)
      do pass = 1, 2
        do j = 1, i - 1
          q(:, i) = q(:, i) - dot_product(q(:, j), q(:, i))*q(:, j)
        end do
        q(:, i) = q(:, i)/norm2(q(:, i))
      end do
    end do
  end subroutine orthonormalise

  !> Does a load act along a translation that nothing resists? If so, `du` is the translation in the
  !! direction of the load, of length one. A body that contact already holds in some direction is
  !! pushed sideways if the deformed surface is not quite level; anchors resist this push.
  subroutine find_flight(hold, model, state, force, floor, loads, du, loaded)
    type(stabilisation_t), intent(in) :: hold
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: force(:, :)  !! (3, nnode) external minus internal force [F]
    real(wp), intent(in) :: floor        !! largest force that counts as zero [F]
    real(wp), intent(in) :: loads        !! sum of all loads [F]
    real(wp), intent(out) :: du(:, :)    !! (3, nnode)
    logical, intent(out) :: loaded
    real(wp), allocatable :: kernel(:, :), turn(:, :), x(:, :), motions(:, :)
    real(wp) :: c(6, size(hold%body)), motion(6, size(hold%body)), along, largest, least
    logical :: touched(size(hold%body))
    integer :: b, i, m

    du = 0.0_wp
    m = size(hold%unheld, 3)
    loaded = .false.
    if (m == 0) return
    turn = reshape(hold%unheld(4:, :, :), [3*size(hold%body), m])
    call null_vectors(matmul(transpose(turn), turn), PURE**2, kernel)
    allocate (x, source=model%mesh%xr + state%u)
    c = 0.0_wp
    largest = 0.0_wp
    do b = 1, size(hold%body)
      largest = max(largest, maxval(abs(force(:, hold%body(b)%node)), &
                                    model%eq(:, hold%body(b)%node) > 0))
    end do
    motions = reshape(hold%unheld, [6*size(hold%body), m])
    call find_touched(hold%body, reshape(matmul(motions, kernel), &
                                         [6, size(hold%body), size(kernel, 2)]), touched)
    do i = 1, size(kernel, 2)
      motion = reshape(matmul(motions, kernel(:, i)), [6, size(hold%body)])
      call rigid_field(hold%body, motion, model%eq, x, du)
      along = sum(force*du)
      least = max(UNLOADED*largest, floor)
      if (all(touched .or. .not. norm2(motion(:3, :), 1) > PURE)) least = max(least, SLOPE*loads)
      if (abs(along) <= least) cycle
      loaded = .true.
      c = c + along*motion
    end do
    if (.not. loaded) return
    call rigid_field(hold%body, c, model%eq, x, du)
    du = du/sqrt(maxval(sum(du**2, 1)))
  end subroutine find_flight

  !> Does contact resist some translation of each body? It does unless the motions that nothing
  !! resists contain as many independent translations of the body as its supports allow.
  subroutine find_touched(body, motions, touched)
    type(free_body_t), intent(in) :: body(:)
    real(wp), intent(in) :: motions(:, :, :) !! (6, body, m) translations that nothing resists
    logical, intent(out) :: touched(:)
    real(wp), allocatable :: allowed(:, :), blocked(:, :)
    integer :: b

    do b = 1, size(body)
      associate (turn => body(b)%motion(4:, :body(b)%nmotion))
        call null_vectors(matmul(transpose(turn), turn), PURE**2, allowed)
      end associate
      call null_vectors(matmul(motions(:3, b, :), transpose(motions(:3, b, :))), PURE, blocked)
      touched(b) = 3 - size(blocked, 2) < size(allowed, 2)
    end do
  end subroutine find_touched

  !> Do the anchors bear a load that is not small? If so, the motion along this load is released for
  !! the rest of the step.
  subroutine release_loaded(hold, model, state, anchors, scale, loaded)
    type(stabilisation_t), intent(inout) :: hold
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(anchors_t), intent(in) :: anchors
    real(wp), intent(in) :: scale        !! sum of all loads [F]
    logical, intent(out) :: loaded
    real(wp) :: motion(6, size(hold%body)), load

    loaded = .false.
    if (.not. allocated(anchors%dv)) return
    call find_load(anchors, hold%body, model%eq, model%mesh%xr + state%u, &
                   state%u - state%u_step, motion, load)
    loaded = load > NO_LOAD*scale
    if (.not. loaded) return
    hold%released = reshape([hold%released, motion], &
                            [6, size(hold%body), size(hold%released, 3) + 1])
  end subroutine release_loaded

  !> Find the distance that bodies may move at once [L]: until the first two surfaces meet, and a
  !! little farther. Contacts between surfaces that move together do not count.
  subroutine find_reach(hold, model, state, du, reach)
    type(stabilisation_t), intent(inout) :: hold
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: du(:, :)     !! (3, nnode) the motion, of any length
    real(wp), intent(out) :: reach
    real(wp), allocatable :: x(:, :)
    real(wp) :: depth, gap, h, little, speed(size(model%contact))
    logical :: within
    integer :: c, k

    allocate (x, source=model%mesh%xr + state%u)
    h = huge(h)
    depth = huge(depth)
    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        speed(c) = relative_speed(contact, du)
        depth = min(depth, contact%depth)
        do k = 1, 2
          if (.not. contact%side(k)%rigid) h = min(h, minval(contact%side(k)%width))
        end do
      end associate
    end do
    if (.not. any(speed > 0.0_wp)) speed = 1.0_wp
    reach = huge(reach)
    do c = 1, size(model%contact)
      associate (n => hold%at_contact(c))
        little = min(LONGEST*min(h, depth), FIRST*h*GROWTH**min(20, n))
        n = n + 1
        gap = huge(gap)
        if (speed(c) > 0.0_wp) then
          within = is_within_body(model, c)
          if (.not. within) gap = find_distance(model%contact(c), model%mesh%xr, x)
          if (gap < huge(gap)) reach = min(reach, (gap + little)/speed(c))
        end if
        if (gap > little) n = 0
      end associate
    end do
  end subroutine find_reach

  !> A bound on the relative velocity of two surfaces of a contact if the fastest node of the model
  !! has the velocity one. It is exact if each surface moves as a whole, and zero if all nodes have
  !! the same displacement.
  pure real(wp) function relative_speed(contact, du) result(speed)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: du(:, :)     !! (3, nnode)
    real(wp) :: mean(3, 2)
    integer :: i, k

    speed = 0.0_wp
    do k = 1, 2
      associate (node => contact%side(k)%node)
        mean(:, k) = sum(du(:, node), 2)/size(node)
        speed = speed + maxval([(norm2(du(:, node(i)) - mean(:, k)), i=1, size(node))])
      end associate
    end do
    speed = (speed + norm2(mean(:, 1) - mean(:, 2)))/sqrt(maxval(sum(du**2, 1)))
    if (speed <= PURE) speed = 0.0_wp
    if (contact%self) speed = max(speed, 1.0_wp)
  end function relative_speed

  !> Add the springs to the tangent.
  subroutine add_springs(hold, k)
    type(stabilisation_t), intent(inout) :: hold
    type(block_matrix_t), intent(inout) :: k
    integer :: b, i, j, m, p

    m = 0
    do b = 1, size(hold%body)
      m = m + size(hold%body(b)%node)
    end do
    if (allocated(hold%kept)) deallocate (hold%kept)
    allocate (hold%kept(3, 3, m))
    m = 0
    do b = 1, size(hold%body)
      do j = 1, size(hold%body(b)%node)
        p = block_position(k, hold%body(b)%node(j), hold%body(b)%node(j))
        m = m + 1
        hold%kept(:, :, m) = k%val(:, :, p)
        if (.not. is_root()) cycle ! ranks add their matrices
        do i = 1, 3
          k%val(i, i, p) = k%val(i, i, p) + SPRING*node_stiffness(k, hold%body(b)%node(j))
        end do
      end do
    end do
  end subroutine add_springs

  !> Restore the tangent without springs, bit for bit.
  subroutine remove_springs(hold, k)
    type(stabilisation_t), intent(inout) :: hold
    type(block_matrix_t), intent(inout) :: k
    integer :: b, j, m, p

    m = 0
    do b = 1, size(hold%body)
      do j = 1, size(hold%body(b)%node)
        p = block_position(k, hold%body(b)%node(j), hold%body(b)%node(j))
        m = m + 1
        k%val(:, :, p) = hold%kept(:, :, m)
      end do
    end do
  end subroutine remove_springs

  !> Work of the springs along an increment [F L].
  pure real(wp) function spring_energy(hold, k, du) result(energy)
    type(stabilisation_t), intent(in) :: hold
    type(block_matrix_t), intent(in) :: k
    real(wp), intent(in) :: du(:, :)     !! (3, nnode) [L]
    integer :: b, j

    energy = 0.0_wp
    do b = 1, size(hold%body)
      do j = 1, size(hold%body(b)%node)
        associate (n => hold%body(b)%node(j))
          energy = energy + SPRING*node_stiffness(k, n)*sum(du(:, n)**2)
        end associate
      end do
    end do
  end function spring_energy

  !> Record that bodies have moved by du.
  subroutine note_move(hold, du)
    type(stabilisation_t), intent(inout) :: hold
    real(wp), intent(in) :: du(:, :)     !! (3, nnode) [L]
    integer :: b

    hold%moves = hold%moves + 1
    do b = 1, size(hold%body)
      associate (node => hold%body(b)%node)
        hold%shift(:, b) = hold%shift(:, b) + sum(du(:, node), 2)/size(node)
      end associate
    end do
  end subroutine note_move

  !> Has a body moved farther than FAR times the size of the model?
  pure logical function is_lost(hold, model)
    type(stabilisation_t), intent(in) :: hold
    type(model_t), intent(in) :: model
    real(wp) :: extent

    extent = maxval(maxval(model%mesh%xr, 2) - minval(model%mesh%xr, 2))
    is_lost = maxval(norm2(hold%shift, 1)) > FAR*extent
  end function is_lost

  !> Have bodies moved too often without coming to rest?
  pure logical function is_restless(hold)
    type(stabilisation_t), intent(in) :: hold

    is_restless = hold%moves >= MOST_MOVES
  end function is_restless

end module stabilisation
