!> The direction in which a body that "flies" (module stabilisation) approaches a surface with
!! friction.
!!
!! Friction measures slip from the point that faced a body at the start of the step. If a body
!! approached an inclined surface in the direction of its load, it would arrive beside this point,
!! and all its points would slip. It therefore takes the shortest way to the surface, unless the
!! load is so oblique that friction cannot hold the body anyway, or supports do not admit this way,
!! or several surfaces are about equally near, as in a groove.
!!
!! If the surface belongs to a body that itself takes the shortest way to a surface, as in a tower
!! of blocks, the body on top moves along with it. Once the lower body is at rest, the upper one
!! closes the gap between them.
module approach
  use base_kinds, only: wp
  use contact_assembly, only: friction_acts
  use contact_type, only: MU
  use model, only: model_t, state_t
  use rigid_modes, only: free_body_t
  use surface_distance, only: find_distance
  implicit none
  private
  public :: approach_surface

  real(wp), parameter :: SAME = 1.0e-6_wp !! difference between equal directions; a translation that
  !! is shorter, relative to the longest one, is due to rounding
  real(wp), parameter :: AS_NEAR = 0.1_wp !! difference between equally near surfaces, relative to
  !! the width of an element

  !> A surface that a body may approach.
  type :: goal_t
    integer :: body = 0                  !! the body that approaches
    integer :: other = 0                 !! the body of the surface; 0 if it is at rest
    integer :: contact = 0
    real(wp) :: gap = 0.0_wp             !! distance [L]
    real(wp) :: way(3) = 0.0_wp          !! shortest way, of length one; zero if it is not known
    real(wp) :: width = 0.0_wp           !! smallest width of an element of the body [L]
  end type goal_t

contains

  !> Turn the translation `du` of each body towards the nearest surface if friction can hold the
  !! body there under a force along `du`. If this surface moves, the body moves along with it.
  !! Bodies are turned in the order of their distances from surfaces at rest and from bodies that
  !! have been turned.
  subroutine approach_surface(body, model, state, du, fell)
    type(free_body_t), intent(in) :: body(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(inout) :: du(:, :)  !! (3, nnode) translations of bodies, of any length
    logical, intent(inout) :: fell       !! set if a body keeps the direction of its load
    real(wp), allocatable :: length(:)   !! (nnode) [L]
    type(goal_t), allocatable :: goal(:)
    real(wp) :: step(3), steps(3, size(body))
    logical :: waits(size(body)), known(0:size(body)), found
    integer :: b, g, nearest

    length = norm2(du, 1)
    where (length <= SAME*maxval(length)) length = 0.0_wp
    call list_goals(body, model, state, length, goal)
    waits = [(any(length(body(b)%node) > 0.0_wp), b=1, size(body))]
    known = .false.
    known(0) = .true.                    ! surfaces at rest
    do
      nearest = 0
      do b = 1, size(body)
        if (.not. waits(b)) cycle
        call find_goal(body(b), model, state, du, length, goal, &
                       goal%body == b .and. known(goal%other), g)
        if (g == 0) cycle
        if (nearest > 0) then
          if (goal(g)%gap >= goal(nearest)%gap) cycle
        end if
        associate (node => body(b)%node)
          if (goal(g)%other == 0) then
            step = goal(g)%way*maxval(length(node))
          else
            step = steps(:, goal(g)%other)
          end if
          found = .not. any(model%eq(:, node) <= 0 &
                            .and. spread(abs(step) > SAME*norm2(step), 2, size(node)))
        end associate
        if (.not. found) cycle
        steps(:, b) = step
        nearest = g
      end do
      if (nearest == 0) exit
      b = goal(nearest)%body
      waits(b) = .false.
      known(b) = .true.
      associate (node => body(b)%node)
        du(:, node) = merge(spread(steps(:, b), 2, size(node)), 0.0_wp, &
                            model%eq(:, node) > 0 .and. spread(length(node) > 0.0_wp, 1, 3))
      end associate
    end do
    fell = fell .or. any(waits)
  end subroutine approach_surface

  !> List the surfaces that the moving bodies may approach.
  subroutine list_goals(body, model, state, length, goal)
    type(free_body_t), intent(in) :: body(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: length(:)    !! (nnode) lengths of translations [L]
    type(goal_t), allocatable, intent(out) :: goal(:)
    type(goal_t) :: new
    real(wp) :: towards(3)
    integer :: owner(size(length))       !! body of each node, if the body moves
    integer :: b, c, k

    allocate (goal(0))
    owner = 0
    do b = 1, size(body)
      if (any(length(body(b)%node) > 0.0_wp)) owner(body(b)%node) = b
    end do
    do c = 1, size(model%contact)
      associate (side => model%contact(c)%side)
        if (model%contact(c)%self) cycle
        if (all(owner(side(1)%node) == 0) .and. all(owner(side(2)%node) == 0)) cycle
        new%contact = c
        new%gap = find_distance(model%contact(c), model%mesh%xr, model%mesh%xr + state%u, towards)
        do k = 1, 2
          new%other = owner(side(3 - k)%node(1))
          if (any(owner(side(3 - k)%node) /= new%other)) cycle
          new%way = merge(towards, -towards, k == 1)
          new%width = minval(side(k)%width)
          do b = 1, size(body)
            new%body = b
            if (b /= new%other .and. any(owner(side(k)%node) == b)) goal = [goal, new]
          end do
        end do
      end associate
    end do
  end subroutine list_goals

  !> Find the surface that a body approaches. There is none (`nearest` is zero) if the translations
  !! of the nodes differ, if surfaces in different directions are about equally near, or if friction
  !! cannot hold the body at the nearest surface.
  subroutine find_goal(body, model, state, du, length, goal, counts, nearest)
    type(free_body_t), intent(in) :: body
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: du(:, :), length(:)
    type(goal_t), intent(in) :: goal(:)
    logical, intent(in) :: counts(:)     !! surfaces of which one is chosen
    integer, intent(out) :: nearest
    real(wp) :: e(3), h
    integer :: g, i, n

    nearest = 0
    if (.not. any(counts)) return
    n = body%node(maxloc(length(body%node), 1))
    e = du(:, n)/length(n)
    do i = 1, size(body%node)
      n = body%node(i)
      if (length(n) > 0.0_wp .and. norm2(du(:, n) - length(n)*e) > SAME*length(n)) return
    end do
    n = minloc(goal%gap, 1, counts)
    associate (way => goal(n)%way, contact => model%contact(goal(n)%contact))
      if (.not. any(abs(way) > 0.0_wp)) return
      h = minval(goal%width, counts)
      do g = 1, size(goal)
        if (.not. counts(g) .or. goal(g)%gap > goal(n)%gap + AS_NEAR*h) cycle
        if (norm2(goal(g)%way - way) > SAME) return
      end do
      if (.not. friction_acts(contact, state)) return
      if (dot_product(way, e)*sqrt(1.0_wp + contact%friction%prop(MU)**2) >= 1.0_wp) nearest = n
    end associate
  end subroutine find_goal

end module approach
