!> The direction in which a body that "flies" (module stabilisation) approaches a surface with
!! friction.
!!
!! Friction measures slip from the point that faced a body at the start of the step. If a body
!! approached an inclined surface in the direction of its load, it would arrive beside this point,
!! and all its points would slip. It therefore takes the shortest way to the surface, unless the
!! load is so oblique that friction cannot hold the body anyway, or supports do not admit this way,
!! or several surfaces are about equally near, as in a groove.
module approach
  use base_kinds, only: wp
  use contact_assembly, only: friction_acts
  use contact_pair, only: contact_t
  use contact_type, only: MU
  use model, only: model_t, state_t
  use rigid_modes, only: free_body_t, is_within_body
  use surface_distance, only: find_distance
  implicit none
  private
  public :: approach_surface

  real(wp), parameter :: SAME = 1.0e-6_wp !! difference between equal directions; a translation that
  !! is shorter, relative to the longest one, is due to rounding
  real(wp), parameter :: AS_NEAR = 0.1_wp !! difference between equally near surfaces, relative to
  !! the width of an element

contains

  !> Turn the translation `du` of each body towards the nearest surface if friction can hold the
  !! body there under a force along `du`.
  subroutine approach_surface(body, model, state, du, fell)
    type(free_body_t), intent(in) :: body(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(inout) :: du(:, :)  !! (3, nnode) translations of bodies, of any length
    logical, intent(inout) :: fell       !! set if a body keeps the direction of its load
    real(wp), allocatable :: length(:)   !! (nnode) [L]
    real(wp) :: way(3)
    logical :: found
    integer :: b

    length = norm2(du, 1)
    where (length <= SAME*maxval(length)) length = 0.0_wp
    do b = 1, size(body)
      associate (node => body(b)%node)
        if (.not. any(length(node) > 0.0_wp)) cycle
        call find_way(body(b), model, state, du, length, way, found)
        if (found) found = .not. any(model%eq(:, node) <= 0 &
                                     .and. spread(abs(way), 2, size(node)) > SAME)
        fell = fell .or. .not. found
        if (.not. found) cycle
        du(:, node) = merge(spread(way, 2, size(node))*spread(length(node), 1, 3), 0.0_wp, &
                            model%eq(:, node) > 0)
      end associate
    end do
  end subroutine approach_surface

  !> Find the shortest way of a body to a surface at rest. It is not `found` if the translations of
  !! the nodes differ, if surfaces in different directions are about equally near, or if friction
  !! cannot hold the body at the nearest surface.
  subroutine find_way(body, model, state, du, length, way, found)
    type(free_body_t), intent(in) :: body
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: du(:, :), length(:)
    real(wp), intent(out) :: way(3)      !! of length one
    logical, intent(out) :: found
    real(wp) :: e(3), towards(3), h, gap, distance(size(model%contact))
    real(wp) :: ways(3, size(model%contact))
    integer :: c, n, side
    logical :: is_own(size(du, 2))

    found = .false.
    n = body%node(maxloc(length(body%node), 1))
    e = du(:, n)/length(n)
    do c = 1, size(body%node)
      n = body%node(c)
      if (length(n) > 0.0_wp .and. norm2(du(:, n) - length(n)*e) > SAME*length(n)) return
    end do
    is_own = .false.
    is_own(body%node) = .true.
    distance = huge(distance)
    h = huge(h)
    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        if (is_within_body(model, c)) cycle
        side = side_of_body(contact, is_own)
        if (side == 0) cycle
        if (any(length(contact%side(3 - side)%node) > 0.0_wp)) cycle
        distance(c) = find_distance(contact, model%mesh%xr, model%mesh%xr + state%u, towards)
        ways(:, c) = merge(towards, -towards, side == 1)
        h = min(h, minval(contact%side(side)%width))
      end associate
    end do
    if (.not. any(distance < huge(distance))) return
    n = minloc(distance, 1)
    gap = distance(n)
    way = ways(:, n)
    if (.not. any(abs(way) > 0.0_wp)) return
    do c = 1, size(distance)
      if (distance(c) > gap + AS_NEAR*h) cycle
      if (norm2(ways(:, c) - way) > SAME) return
    end do
    if (.not. friction_acts(model%contact(n), state)) return
    associate (mu_n => model%contact(n)%friction%prop(MU))
      found = dot_product(way, e)*sqrt(1.0_wp + mu_n**2) >= 1.0_wp
    end associate
  end subroutine find_way

  !> The side of a contact that belongs to the body with the nodes `is_own`, or 0.
  pure integer function side_of_body(contact, is_own) result(side)
    type(contact_t), intent(in) :: contact
    logical, intent(in) :: is_own(:)     !! (nnode)

    do side = 2, 1, -1
      if (any(is_own(contact%side(side)%node))) return
    end do
    side = 0
  end function side_of_body

end module approach
