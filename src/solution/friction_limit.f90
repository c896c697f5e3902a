!> Bodies that friction cannot keep from sliding away: their loads lie outside the cone of the
!! forces that contact can bear.
!!
!! Contact pushes a body along directions d, which are the normals of its own faces or of the
!! opposite faces. If all of them lie within an angle a of their mean m, every force that contact
!! with friction mu can bear lies within a + atan(mu) of m. If the loads require a force outside
!! this cone, there is no equilibrium, however small the step is. Directions in which the body is
!! supported are ignored if m has no component along them; otherwise the body is not examined.
module friction_limit
  use base_kinds, only: wp
  use base_text, only: to_text
  use contact_pair, only: contact_t, surface_t
  use contact_type, only: MU
  use external_load, only: load_rates
  use load_curve, only: table_factor
  use model, only: model_t, state_t
  use projection_type, only: shape_t
  use rigid_modes, only: free_body_t, is_within_body
  use stabilisation_report, only: direction_text
  use surface_geometry, only: surface_point, update_shape
  use tensor, only: cross
  implicit none
  private
  public :: sliding_text

  real(wp), parameter :: RIGHT_ANGLE = acos(0.0_wp)
  real(wp), parameter :: ACROSS = 1.0e-3_wp !! negligible component of m in a supported direction
  real(wp), parameter :: MORE = 1.0e-3_wp   !! [rad] angle beyond the cone that counts as rounding
  real(wp), parameter :: NEAR = 0.9_wp      !! loads beyond this fraction of the angle of the cone
  !! are near the limit

contains

  !> Name a body that friction cannot hold, and say how it slides; empty if there is none. If the
  !! loads of the failed step are only near the limit of friction, those at a later time are
  !! examined, because the last step before the limit often fails.
  function sliding_text(model, state, body, load, ahead) result(text)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(free_body_t), intent(in) :: body(:) !! bodies that only contact can hold
    real(wp), intent(in) :: load(:, :)       !! (3, nnode) loads of the failed step [F]
    real(wp), intent(in) :: ahead            !! the later time
    character(:), allocatable :: text
    type(state_t) :: start
    real(wp), allocatable :: x(:, :), later(:, :)
    integer :: i

    allocate (x, source=model%mesh%xr + state%u_step)
    text = slide_under(model, body, x, load, 1.0_wp)
    if (len(text) > 0 .or. .not. ahead > state%time) return
    if (len(slide_under(model, body, x, load, NEAR)) == 0) return
    start%u = state%u_step
    allocate (later, mold=load)
    call load_rates(model, start, [(table_factor(state%table(i), ahead), i=1, size(state%table))], &
                    later)
    text = slide_under(model, body, x, later, 1.0_wp)
    if (len(text) > 0) text = 'at time '//to_text(ahead)//', '//text
  end function sliding_text

  !> Name the first body whose loads are beyond a fraction of the cone of friction.
  function slide_under(model, body, x, load, part) result(text)
    type(model_t), intent(in) :: model
    type(free_body_t), intent(in) :: body(:)
    real(wp), intent(in) :: x(:, :)          !! (3, nnode) positions at the start of the step [L]
    real(wp), intent(in) :: load(:, :)       !! (3, nnode) [F]
    real(wp), intent(in) :: part             !! fraction of the angle of the cone beyond which loads
    !! count
    character(:), allocatable :: text
    real(wp) :: m(3), r(3), along(3), spread, largest, limit
    integer :: b, i

    text = ''
    do b = 1, size(body)
      call find_cone(model, body(b), x, m, spread, largest)
      if (.not. largest > 0.0_wp) cycle
      r = -sum(load(:, body(b)%node), 2)
      do i = 1, 3
        if (all(model%eq(i, body(b)%node) /= 0)) cycle
        if (abs(m(i)) > ACROSS) exit
        r(i) = 0.0_wp
      end do
      if (i <= 3) cycle
      along = r - dot_product(r, m)*m
      if (.not. dot_product(r, m) > 0.0_wp) cycle
      limit = spread + atan(largest)
      if (limit >= RIGHT_ANGLE) cycle
      if (.not. atan2(norm2(along), dot_product(r, m)) > part*limit + MORE) cycle
      text = body(b)%name//' slides along '//direction_text(-along)//', where only friction ' &
             //'holds it: its loads tangential to the contact are ' &
             //to_text(norm2(along)/dot_product(r, m), 3)//' times its normal loads, but ' &
             //'friction can resist at most '//to_text(largest, 3)//' times the normal loads'
      return
    end do
  end function slide_under

  !> The mean direction m in which contacts push a body, the largest angle between m and the
  !! directions of single points, and the largest coefficient of friction, which is zero if no
  !! contact of the body has friction.
  subroutine find_cone(model, body, x, m, spread, largest)
    type(model_t), intent(in) :: model
    type(free_body_t), intent(in) :: body
    real(wp), intent(in) :: x(:, :)
    real(wp), intent(out) :: m(3), spread, largest
    real(wp), allocatable :: d(:, :), own(:, :), others(:, :)
    logical :: inside(size(x, 2))
    integer :: c, k

    inside = .false.
    inside(body%node) = .true.
    largest = 0.0_wp
    allocate (d(3, 0))
    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        if (is_within_body(model, c)) cycle
        do k = 1, 2
          if (contact%side(k)%rigid) cycle
          if (.not. any(inside(contact%side(k)%node))) cycle
          if (contact%friction%given) largest = max(largest, contact%friction%prop(MU))
          own = -normals(contact, contact%side(k), x, inside)
          others = normals(contact, contact%side(3 - k), x)
          if (spread_of(others) < spread_of(own)) own = others
          d = reshape([d, own], [3, size(d, 2) + size(own, 2)])
        end do
      end associate
    end do
    m = mean_of(d)
    spread = spread_of(d)
  end subroutine find_cone

  !> Outward unit normals of a surface at its integration points. If `inside` is present, it selects
  !! the elements by their first nodes.
  function normals(contact, surface, x, inside) result(n)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: x(:, :)
    logical, intent(in), optional :: inside(:) !! (nnode)
    real(wp), allocatable :: n(:, :)
    type(shape_t) :: shape
    real(wp) :: xp(3), a(3, 2), b(3, 3)
    integer :: e, i, q

    call update_shape(surface, x, shape)
    allocate (n(3, surface%nelem*contact%nplain))
    i = 0
    do e = 1, surface%nelem
      if (present(inside)) then
        if (.not. inside(surface%node(surface%first(e)))) cycle
      end if
      do q = 1, contact%nplain
        call surface_point(surface, shape, e, contact%xi(:, q), xp, a, b)
        i = i + 1
        n(:, i) = cross(a(:, 1), a(:, 2))
        n(:, i) = n(:, i)/max(norm2(n(:, i)), tiny(1.0_wp))
      end do
    end do
    n = n(:, :i)
  end function normals

  pure function mean_of(d) result(m)
    real(wp), intent(in) :: d(:, :)      !! (3, n) unit vectors
    real(wp) :: m(3)

    m = sum(d, 2)
    if (norm2(m) > 0.0_wp) m = m/norm2(m)
  end function mean_of

  !> Largest angle between unit vectors and their mean; pi if there are none.
  pure real(wp) function spread_of(d) result(angle)
    real(wp), intent(in) :: d(:, :)      !! (3, n)
    real(wp) :: m(3)
    integer :: i

    angle = 2*RIGHT_ANGLE
    if (size(d, 2) == 0) return
    m = mean_of(d)
    angle = 0.0_wp
    do i = 1, size(d, 2)
      angle = max(angle, atan2(norm2(cross(d(:, i), m)), dot_product(d(:, i), m)))
    end do
  end function spread_of

end module friction_limit
