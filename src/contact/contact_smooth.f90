!> Smooth fields of one side of a contact, from its integration points to nodes and control points:
!!
!!   T_A = int N_A t da / int N_A da
!!
!! on the current surface (N_A^2 for N_A where a function has no area), interpolated with the same
!! functions (Sauer 2013). Values at the points themselves oscillate; only these fields are to be
!! compared and looked at. Friction's part of the
!! traction is smoothed by itself: the tangential part of the smooth traction would take in some of
!! the pressure wherever the surface is curved (5 % of Table 5's values, Corbett and Sauer 2015).
module contact_smooth
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t, surface_t, surface_basis_t
  use contact_surface, only: surface_functions_at, make_rational
  use contact_type, only: OPEN, STICK, SLIP, TOUCH
  implicit none
  private
  public :: smooth_t, smooth_side, largest_pressure, largest_tangential

  !> Coefficients at the nodes of a side.
  type :: smooth_t
    integer, allocatable :: node(:)         !! (n) nodes and control points of the side, each once
    integer, allocatable :: at(:)           !! (size(surface%node)) their places in `node`
    real(wp), allocatable :: traction(:, :) !! (3, n) on this side [F/L^2]
    real(wp), allocatable :: friction(:, :) !! (3, n) part of it that friction holds [F/L^2]
    real(wp), allocatable :: pressure(:)    !! (n) [F/L^2]
    real(wp), allocatable :: slip(:, :)     !! (3, n) [L] contact_points_t, elastic
    real(wp), allocatable :: state(:)       !! (n) 0 open, 1 stick (or no friction), 2 slip
    real(wp), allocatable :: gap(:)         !! (n) [L] of the points above the other surface
  end type smooth_t

  !> Share of a squared pressure that may be rounding.
  real(wp), parameter :: ROUNDING = 64.0_wp*epsilon(1.0_wp)

  !> Rows of the sums; 1 to 11 as in add_point.
  integer, parameter :: AREA = 12, GAP = 13, GAP_AREA = 14, NSUM = 14

  !> Where a field is looked at: NGRID x NGRID points an element, evenly spread from border to
  !! border: fields of facets have their largest values at corners.
  integer, parameter :: NGRID = 10

  !> Functions of one basis of elements at these points, without weights.
  type :: table_t
    real(wp), allocatable :: shp(:, :)      !! (nsf, NGRID**2)
    real(wp), allocatable :: dshp(:, :, :)  !! (2, nsf, NGRID**2)
  end type table_t

contains

  !> All fields of side k; it must not be rigid.
  subroutine smooth_side(contact, k, points, field)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    type(smooth_t), intent(out) :: field
    real(wp), allocatable :: total(:, :), shp(:), dshp(:, :)
    logical :: squares
    integer :: e, i, q

    associate (own => contact%side(k))
      call number_nodes(own, field)
      allocate (total(NSUM, size(field%node)), source=0.0_wp)
      do e = 1, own%nelem
        associate (basis => own%basis(own%ibasis(e)), first => own%first(e), &
                   last => own%first(e + 1) - 1)
          squares = has_no_area(basis, points%area((e - 1)*contact%nq + 1:e*contact%nq))
          do q = 1, contact%nq
            i = (e - 1)*contact%nq + q
            shp = basis%shp(:, q)
            dshp = basis%dshp(:, :, q)
            if (allocated(own%w)) call make_rational(own%w(first:last), shp, dshp)
            if (squares) shp = shp**2
            call add_point(points, i, shp, field%at(first:last), total)
          end do
        end associate
      end do
    end associate
    call divide(total, points, field)
  end subroutine smooth_side

  !> Functions of no area (corners of quadratic triangles): their squares are the weights then.
  pure logical function has_no_area(basis, area)
    type(surface_basis_t), intent(in) :: basis
    real(wp), intent(in) :: area(:)      !! (nq) of the points [L^2]
    real(wp) :: total(basis%nsf)
    real(wp), parameter :: NONE = 1.0e-3_wp !! of the largest

    total = matmul(basis%shp, area)
    has_no_area = any(total <= NONE*maxval(total)) .and. any(basis%shp < 0.0_wp)
  end function has_no_area

  !> Give each node of the side a place.
  pure subroutine number_nodes(surface, field)
    type(surface_t), intent(in) :: surface
    type(smooth_t), intent(inout) :: field
    integer, allocatable :: place(:)
    integer :: i, n

    allocate (place(maxval(surface%node)), source=0)
    allocate (field%at(size(surface%node)))
    n = 0
    do i = 1, size(surface%node)
      if (place(surface%node(i)) == 0) then
        n = n + 1
        place(surface%node(i)) = n
      end if
      field%at(i) = place(surface%node(i))
    end do
    allocate (field%node(n))
    field%node(field%at) = surface%node
  end subroutine number_nodes

  !> Values of one point, times its area and the functions there.
  pure subroutine add_point(points, i, shp, at, total)
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i
    real(wp), intent(in) :: shp(:)         !! (nsf)
    integer, intent(in) :: at(:)           !! (nsf)
    real(wp), intent(inout) :: total(:, :) !! (NSUM, n)
    real(wp) :: value(NSUM)
    integer :: a

    value = 0.0_wp
    value(AREA) = 1.0_wp
    if (points%state(i) /= OPEN) then
      value(1:3) = points%traction(:, i)
      value(4) = points%pressure(i)
      value(5:7) = points%elastic(:, i)
      value(8) = share_of(points%state(i))
      value(9:11) = friction_of(points%traction(:, i), points%pressure(i), points%elastic(:, i))
    end if
    if (points%foot(i) > 0 .and. points%gap(i) < huge(1.0_wp)) then
      value(GAP) = points%gap(i)
      value(GAP_AREA) = 1.0_wp
    end if
    value = points%area(i)*value
    do a = 1, size(shp)
      total(:, at(a)) = total(:, at(a)) + shp(a)*value
    end do
  end subroutine add_point

  !> Friction acts along the elastic part of the tangential way, the pressure across it. A way that
  !! is rounding points anywhere: friction is not more than what the pressure leaves of t.
  pure function friction_of(t, p, elastic) result(friction)
    real(wp), intent(in) :: t(3), p, elastic(3)
    real(wp) :: friction(3)
    real(wp) :: size, most

    friction = 0.0_wp
    size = norm2(elastic)
    if (.not. size > 0.0_wp) return
    friction = dot_product(t, elastic/size)*(elastic/size)
    most = sqrt(max(0.0_wp, dot_product(t, t) - p*p) + ROUNDING*p*p)
    if (norm2(friction) > most) friction = friction*(most/norm2(friction))
  end function friction_of

  pure real(wp) function share_of(state)
    integer, intent(in) :: state

    select case (state)
    case (STICK, TOUCH)
      share_of = 1.0_wp
    case (SLIP)
      share_of = 2.0_wp
    case default
      share_of = 0.0_wp
    end select
  end function share_of

  !> Means. A node round which no point has a foot is shown as far as the farthest point with one.
  pure subroutine divide(total, points, field)
    real(wp), intent(in) :: total(:, :)
    type(contact_points_t), intent(in) :: points
    type(smooth_t), intent(inout) :: field
    real(wp) :: far
    integer :: a, n

    n = size(total, 2)
    far = maxval(points%gap, mask=points%foot > 0 .and. points%gap < huge(far))
    if (far < -0.5_wp*huge(far)) far = 0.0_wp   ! no point has a foot
    allocate (field%traction(3, n), field%friction(3, n), field%slip(3, n), source=0.0_wp)
    allocate (field%pressure(n), field%state(n), source=0.0_wp)
    allocate (field%gap(n), source=far)
    do a = 1, n
      if (total(AREA, a) > 0.0_wp) then
        field%traction(:, a) = total(1:3, a)/total(AREA, a)
        field%pressure(a) = total(4, a)/total(AREA, a)
        field%slip(:, a) = total(5:7, a)/total(AREA, a)
        field%state(a) = total(8, a)/total(AREA, a)
        field%friction(:, a) = total(9:11, a)/total(AREA, a)
      end if
      if (total(GAP_AREA, a) > 0.0_wp) field%gap(a) = min(far, total(GAP, a)/total(GAP_AREA, a))
    end do
  end subroutine divide

  !> Largest smooth pressure on NGRID x NGRID points an element, or one component of the traction
  !! without friction.
  function largest_pressure(contact, k, field, component) result(largest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(smooth_t), intent(in) :: field
    integer, intent(in) :: component       !! 1 to 3; 0: the pressure
    real(wp) :: largest
    real(wp), allocatable :: value(:, :)

    allocate (value(1, size(field%pressure)))
    value(1, :) = field%pressure
    if (component > 0) value(1, :) = field%traction(component, :) - field%friction(component, :)
    largest = largest_of(contact%side(k), field%at, value)
  end function largest_pressure

  !> Largest smooth friction on NGRID x NGRID points an element, its magnitude or one component's.
  function largest_tangential(contact, k, field, component) result(largest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(smooth_t), intent(in) :: field
    integer, intent(in) :: component       !! 1 to 3; 0: the magnitude
    real(wp) :: largest

    if (component == 0) then
      largest = largest_of(contact%side(k), field%at, field%friction)
    else
      largest = largest_of(contact%side(k), field%at, field%friction(component:component, :))
    end if
  end function largest_tangential

  !> Largest length of an interpolated field.
  function largest_of(surface, at, value) result(largest)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: at(:)           !! places of the elements' nodes in `value`
    real(wp), intent(in) :: value(:, :)    !! (ncomp, n)
    real(wp) :: largest
    type(table_t), allocatable :: table(:)
    real(wp), allocatable :: shp(:), dshp(:, :)
    integer :: e, i

    largest = 0.0_wp
    call tabulate(surface%basis, table)
    do e = 1, surface%nelem
      associate (mine => at(surface%first(e):surface%first(e + 1) - 1))
        if (all(abs(value(:, mine)) <= 0.0_wp)) cycle
        do i = 1, NGRID**2
          call take(surface, e, table(surface%ibasis(e)), i, shp, dshp)
          largest = max(largest, norm2(matmul(value(:, mine), shp)))
        end do
      end associate
    end do
  end function largest_of

  !> Functions of all bases on the grid.
  subroutine tabulate(basis, table)
    type(surface_basis_t), intent(in) :: basis(:)
    type(table_t), allocatable, intent(out) :: table(:)
    integer :: i, j, k

    allocate (table(size(basis)))
    do k = 1, size(basis)
      allocate (table(k)%shp(basis(k)%nsf, NGRID**2), table(k)%dshp(2, basis(k)%nsf, NGRID**2))
      do j = 1, NGRID
        do i = 1, NGRID
          associate (n => (j - 1)*NGRID + i)
            call surface_functions_at(basis(k), [place(i), place(j)], table(k)%shp(:, n), &
                                      table(k)%dshp(:, :, n))
          end associate
        end do
      end do
    end do
  end subroutine tabulate

  !> i-th of NGRID places from -1 to 1.
  pure real(wp) function place(i)
    integer, intent(in) :: i

    place = real(2*i - NGRID - 1, wp)/real(NGRID - 1, wp)
  end function place

  !> Functions of element e at grid point i, weights included.
  pure subroutine take(surface, e, table, i, shp, dshp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, i
    type(table_t), intent(in) :: table
    real(wp), allocatable, intent(inout) :: shp(:), dshp(:, :)

    shp = table%shp(:, i)
    dshp = table%dshp(:, :, i)
    if (.not. allocated(surface%w)) return
    call make_rational(surface%w(surface%first(e):surface%first(e + 1) - 1), shp, dshp)
  end subroutine take

end module contact_smooth
