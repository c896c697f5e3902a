!> The direction in which a body that "flies" (module stabilisation) approaches a surface with
!! friction.
!!
!! Friction measures slip from the point that faced a body at the start of the step. If a body
!! approached an inclined surface in the direction of its load, it would arrive beside this point,
!! and all its points would slip. It therefore takes the shortest way to the surface, unless the
!! load is so oblique that friction cannot hold the body anyway, or supports do not admit this way.
module approach
  use base_kinds, only: wp
  use contact_assembly, only: friction_acts
  use contact_type, only: MU
  use model, only: model_t, state_t
  use rigid_modes, only: is_within_body
  use surface_distance, only: find_distance
  implicit none
  private
  public :: approach_surface

  real(wp), parameter :: SAME = 1.0e-6_wp      !! difference between equal directions

contains

  !> If the nearest surface has friction that can hold a body under a force along `du`, turn the
  !! translation `du` towards this surface. If two surfaces are equally near in directions equally
  !! inclined to `du`, such as the faces of a groove, the body meets both at once on its way.
  subroutine approach_surface(model, state, du)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(inout) :: du(:, :)  !! (3, nnode) translations of bodies, of any length
    real(wp), allocatable :: x(:, :), size_of(:)
    real(wp) :: e(3), gap, distance, towards(3), way(3), coefficient
    logical :: moves(2), holds, meets_two
    integer :: c, n

    size_of = norm2(du, 1)
    n = maxloc(size_of, 1)
    e = du(:, n)/size_of(n)
    do n = 1, size(du, 2)
      if (.not. size_of(n) > 0.0_wp) cycle
      if (norm2(du(:, n) - size_of(n)*e) > SAME*size_of(n)) return
    end do
    allocate (x, source=model%mesh%xr + state%u)
    gap = 0.5_wp*huge(gap)
    holds = .false.
    meets_two = .false.
    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        if (is_within_body(model, c)) cycle
        do n = 1, 2
          moves(n) = any(size_of(contact%side(n)%node) > 0.0_wp)
        end do
        if (moves(1) .eqv. moves(2)) cycle
        distance = find_distance(contact, model%mesh%xr, x, towards)
        if (.not. distance < (1.0_wp + SAME)*gap) cycle
        towards = merge(towards, -towards, moves(1))
        if (distance > (1.0_wp - SAME)*gap) then
          if (abs(dot_product(towards - way, e)) <= SAME) then
            meets_two = meets_two .or. norm2(towards - way) > SAME
          end if
          cycle
        end if
        gap = distance
        way = towards
        meets_two = .false.
        coefficient = contact%friction%prop(MU)
        holds = friction_acts(contact, state)
        if (holds) holds = dot_product(way, e)*sqrt(1.0_wp + coefficient**2) >= 1.0_wp
      end associate
    end do
    if (meets_two .or. .not. holds) return
    do n = 1, size(du, 2)
      if (.not. size_of(n) > 0.0_wp) cycle
      if (any(model%eq(:, n) <= 0 .and. abs(way) > SAME)) return
    end do
    do n = 1, size(du, 2)
      du(:, n) = merge(size_of(n)*way, 0.0_wp, model%eq(:, n) > 0)
    end do
  end subroutine approach_surface

end module approach
