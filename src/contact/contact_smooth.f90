!> Smooth fields of one side of a contact. The value T_A at a node or control point is found from
!! the values t at the integration points:
!!
!!   T_A = int N_A t da / int N_A da
!!
!! where the integrals are taken over the current surface, and N_A are the functions with which T_A
!! is then interpolated (Sauer 2013). N_A^2 replaces N_A in elements with functions whose integral
!! vanishes. Values at the integration points oscillate; only these smooth fields should be compared
!! and plotted. With the mortar scheme, the integral in the numerator is taken over the cells, at
!! whose points the forces act. Otherwise, a contact that lies between the integration points of
!! whole elements would have no pressure.
!!
!! With the mortar scheme and BALAnced, the points of both sides load this side, each with half of
!! its traction. The numerator is then the mean of the integrals over the points of both sides;
!! those of the other side have the functions N_A at their projections, and the opposite traction.
!! The integral of the smooth traction is therefore the force on this side. If only the own points
!! were counted, a side whose points lie in the gaps beside the points of contact of the other side
!! would have no pressure.
!!
!! The tractions of friction and of the normal law are smoothed separately: the tangential part of
!! the smooth traction would contain some of the pressure wherever the surface is curved (5 % of the
!! values of Table 5, Corbett and Sauer 2015), and the whole traction contains that of bonds.
module contact_smooth
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t, surface_t, surface_basis_t
  use contact_type, only: OPEN, SLIP
  use contact_work, only: element_functions, own_share
  use surface_basis, only: surface_functions_at, make_rational
  implicit none
  private
  public :: smooth_t, smooth_side, find_areas, largest_pressure, largest_tangential, number_nodes, &
            count_nodes, find_squares, weighting_functions, reverse

  !> Coefficients at the nodes of a side.
  type :: smooth_t
    integer, allocatable :: node(:)         !! (n) nodes and control points of the side, each once
    integer, allocatable :: at(:) !! (size(surface%node)) positions of these nodes in `node`
    real(wp), allocatable :: traction(:, :) !! (3, n) traction on this side [F/L^2]
    real(wp), allocatable :: friction(:, :) !! (3, n) the frictional part of the traction [F/L^2]
    real(wp), allocatable :: normal(:, :)   !! (3, n) the part due to the normal law [F/L^2]
    real(wp), allocatable :: pressure(:)    !! (n) [F/L^2]
    real(wp), allocatable :: slip(:, :)     !! (3, n) elastic tangential displacement [L]
    real(wp), allocatable :: state(:)       !! (n) 0 open, 1 stick (or no friction), 2 slip
    real(wp), allocatable :: gap(:)         !! (n) height of the points above the other surface [L]
    logical, allocatable :: faces(:)        !! (n) some point near the node has a projection
  end type smooth_t

  !> Rows of the sums in points%spread: traction, pressure, elastic slip, state, friction, and
  !! traction of the normal law.
  integer, parameter, public :: NSPREAD = 14
  !> Further rows of the sums: areas, gaps, and the areas to which the gaps belong.
  integer, parameter :: AREA = 15, GAP = 16, GAP_AREA = 17, NSUM = 17

  !> Largest values are taken over NGRID x NGRID points per element, evenly spaced from edge to
  !! edge, because bilinear fields have their largest values at corners.
  integer, parameter :: NGRID = 10

contains

  !> Find all fields of side k, which must not be rigid. If no point near a node has a projection,
  !! the node is given the gap of the farthest point that has one, and `faces` is false.
  subroutine smooth_side(contact, k, points, field, others)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    type(smooth_t), intent(out) :: field
    !> Points of the other side, which with BALAnced load side k too; absent: they do not count.
    type(contact_points_t), intent(in), optional :: others
    real(wp), allocatable :: total(:, :), shp(:)
    real(wp) :: far
    logical, allocatable :: squares(:)
    integer :: a, e, i, n, q

    associate (own => contact%side(k))
      call number_nodes(own%node, field%node, field%at)
      n = size(field%node)
      allocate (total(NSUM, n), source=0.0_wp)
      squares = find_squares(contact, k, points)
      do e = 1, own%nelem
        associate (first => own%first(e), last => own%first(e + 1) - 1)
          do q = 1, contact%nq
            i = (e - 1)*contact%nq + q
            call weights_of_point(own, e, q, squares, shp)
            call add_point(points, i, shp, field%at(first:last), total)
          end do
        end associate
      end do
      if (present(others) .and. contact%balanced .and. own_share(contact) < 1.0_wp) then
        total(:NSPREAD, :) = own_share(contact)*total(:NSPREAD, :)
        call add_others(contact, own, others, squares, field%at, total)
      end if
    end associate
    if (allocated(points%spread)) total(:NSPREAD, :) = points%spread
    far = maxval(points%gap, mask=points%closest > 0 .and. points%gap < huge(far))
    if (far < -0.5_wp*huge(far)) far = 0.0_wp   ! no point has a projection
    allocate (field%traction(3, n), field%friction(3, n), field%normal(3, n), field%slip(3, n), &
              source=0.0_wp)
    allocate (field%pressure(n), field%state(n), source=0.0_wp)
    allocate (field%gap(n), source=far)
    allocate (field%faces(n), source=.false.)
    do a = 1, n
      if (total(AREA, a) > 0.0_wp) then
        field%traction(:, a) = total(1:3, a)/total(AREA, a)
        field%pressure(a) = total(4, a)/total(AREA, a)
        field%slip(:, a) = total(5:7, a)/total(AREA, a)
        field%state(a) = total(8, a)/total(AREA, a)
        field%friction(:, a) = total(9:11, a)/total(AREA, a)
        field%normal(:, a) = total(12:14, a)/total(AREA, a)
      end if
      if (total(GAP_AREA, a) > 0.0_wp) then
        field%gap(a) = min(far, total(GAP, a)/total(GAP_AREA, a))
        field%faces(a) = .true.
      end if
    end do
  end subroutine smooth_side

  !> Find the areas with which the nodes of each element of side k count in smooth_side, int N_A da.
  pure subroutine find_areas(contact, k, points, area)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points !! points of side k
    real(wp), intent(out) :: area(:)             !! (size(surface%node)) [L^2]
    real(wp), allocatable :: shp(:)
    logical :: squares(contact%side(k)%nelem)
    integer :: e, q

    squares = find_squares(contact, k, points)
    associate (own => contact%side(k))
      do e = 1, own%nelem
        associate (mine => area(own%first(e):own%first(e + 1) - 1))
          mine = 0.0_wp
          do q = 1, contact%nq
            call weights_of_point(own, e, q, squares, shp)
            mine = mine + points%area((e - 1)*contact%nq + q)*shp
          end do
        end associate
      end do
    end associate
  end subroutine find_areas

  !> Weights of the nodes of element e at its integration point q: the functions or their squares.
  pure subroutine weights_of_point(surface, e, q, squares, shp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, q
    logical, intent(in) :: squares(:)              !! (nelem) see find_squares
    real(wp), allocatable, intent(inout) :: shp(:) !! (nsf)
    real(wp), allocatable :: dshp(:, :)

    associate (basis => surface%basis(surface%ibasis(e)))
      shp = basis%shp(:, q)
      if (allocated(surface%w)) then
        dshp = basis%dshp(:, :, q)
        call make_rational(surface%w(surface%first(e):surface%first(e + 1) - 1), shp, dshp)
      end if
    end associate
    if (squares(e)) shp = shp**2
  end subroutine weights_of_point

  !> Mark the elements of side k in which the squares of the functions are the weights.
  pure function find_squares(contact, k, points) result(squares)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points !! points of side k
    logical :: squares(contact%side(k)%nelem)
    integer :: e

    associate (own => contact%side(k))
      do e = 1, own%nelem
        squares(e) = has_no_area(own%basis(own%ibasis(e)), &
                                 points%area((e - 1)*contact%nq + 1:e*contact%nq))
      end do
    end associate
  end function find_squares

  !> Weights of the nodes of element e of a surface at a point: the functions or their squares.
  pure subroutine weighting_functions(surface, e, xi, squares, shp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    logical, intent(in) :: squares(:)    !! (nelem) see find_squares
    real(wp), intent(out) :: shp(:)      !! (nsf)
    real(wp) :: dshp(2, size(shp))

    call element_functions(surface, e, xi, shp, dshp)
    if (squares(e)) shp = shp**2
  end subroutine weighting_functions

  !> Are there functions whose integral vanishes (at corners of quadratic triangles), so that the
  !! squares are used as weights?
  pure logical function has_no_area(basis, area)
    type(surface_basis_t), intent(in) :: basis
    real(wp), intent(in) :: area(:)      !! (nq) areas of the points [L^2]
    real(wp) :: total(basis%nsf)
    real(wp), parameter :: NONE = 1.0e-3_wp !! an integral vanishes below this, relative to the
    !! largest

    total = matmul(basis%shp, area)
    has_no_area = any(total <= NONE*maxval(total)) .and. any(basis%shp < 0.0_wp)
  end function has_no_area

  !> List the nodes of a side, each once, in the order of their first appearance.
  pure subroutine number_nodes(list, node, at)
    integer, intent(in) :: list(:)
    integer, allocatable, intent(out) :: node(:)
    integer, allocatable, intent(out) :: at(:)   !! (size(list)), so that list = node(at)
    integer, allocatable :: position(:)
    integer :: i, n

    allocate (position(maxval(list)), source=0)
    allocate (at(size(list)))
    n = 0
    do i = 1, size(list)
      if (position(list(i)) == 0) then
        n = n + 1
        position(list(i)) = n
      end if
      at(i) = position(list(i))
    end do
    allocate (node(n))
    node(at) = list
  end subroutine number_nodes

  !> The number of nodes of a side, each counted once.
  pure integer function count_nodes(list) result(n)
    integer, intent(in) :: list(:)
    integer, allocatable :: node(:), at(:)

    call number_nodes(list, node, at)
    n = size(node)
  end function count_nodes

  !> Add the values of one point, multiplied by its area and by the functions there.
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
    if (bears(points, i)) value(:NSPREAD) = borne_values(points, i)
    if (points%closest(i) > 0 .and. points%gap(i) < huge(1.0_wp)) then
      value(GAP) = points%gap(i)
      value(GAP_AREA) = 1.0_wp
    end if
    value = points%area(i)*value
    do a = 1, size(shp)
      total(:, at(a)) = total(:, at(a)) + shp(a)*value
    end do
  end subroutine add_point

  !> Add the part of the values of the points of the other side that acts on this side: at their
  !! projections or, if only the bond holds the point, or it has no projection, at its partner.
  pure subroutine add_others(contact, own, others, squares, at, total)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: own     !! this side
    type(contact_points_t), intent(in) :: others
    logical, intent(in) :: squares(:)      !! (nelem) see find_squares
    integer, intent(in) :: at(:)           !! positions of the nodes of the elements in `total`
    real(wp), intent(inout) :: total(:, :) !! (NSUM, n)
    real(wp) :: value(NSPREAD), xi(2), shp(maxval(own%basis%nsf))
    integer :: a, e, i, n

    do i = 1, size(others%state)
      if (.not. bears(others, i)) cycle
      e = others%closest(i)
      xi = others%closest_xi(:, i)
      if (e == 0 .or. others%state(i) == OPEN) then
        e = others%bond(i)
        xi = others%bond_xi(:, i)
      end if
      if (e == 0) cycle
      value = (1.0_wp - own_share(contact))*others%area(i)*reverse(borne_values(others, i))
      n = own%first(e + 1) - own%first(e)
      call weighting_functions(own, e, xi, squares, shp(:n))
      do a = 1, n
        associate (sums => total(:NSPREAD, at(own%first(e) + a - 1)))
          sums = sums + shp(a)*value
        end associate
      end do
    end do
  end subroutine add_others

  !> Does a point bear a traction: is it in contact, or bonded?
  pure logical function bears(points, i)
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i

    bears = points%state(i) /= OPEN .or. points%bond(i) > 0
  end function bears

  !> Values of a point that bears a traction. The traction of a bond is part of the traction, but
  !! neither pressure nor friction; a bonded point whose bond is in tension is OPEN.
  pure function borne_values(points, i) result(value)
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i
    real(wp) :: value(NSPREAD)

    value(1:3) = points%traction(:, i)
    value(4) = points%pressure(i)
    value(5:7) = points%elastic(:, i)
    value(8) = merge(2.0_wp, 1.0_wp, points%state(i) == SLIP)
    if (points%state(i) == OPEN) value(8) = 0.0_wp
    value(9:11) = points%friction(:, i)
    value(12:14) = points%normal(:, i)
  end function borne_values

  !> Values with which a point acts on the other side: the vectors are reversed.
  pure function reverse(value) result(back)
    real(wp), intent(in) :: value(NSPREAD)
    real(wp) :: back(NSPREAD)

    back = -value
    back([4, 8]) = value([4, 8])
  end function reverse

  !> Largest magnitude of the smooth pressure, or of one component of its traction.
  function largest_pressure(contact, k, field, component) result(largest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(smooth_t), intent(in) :: field
    integer, intent(in) :: component       !! 1 to 3; 0: the pressure
    real(wp) :: largest
    real(wp), allocatable :: value(:, :)

    allocate (value(1, size(field%pressure)))
    value(1, :) = field%pressure
    if (component > 0) value(1, :) = field%normal(component, :)
    largest = largest_of(contact%side(k), field%at, value)
  end function largest_pressure

  !> Largest magnitude of the smooth friction, or of one component of it.
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

  !> Largest norm of an interpolated field on the grid of points of all elements.
  function largest_of(surface, at, value) result(largest)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: at(:)           !! positions of the nodes of the elements in `value`
    real(wp), intent(in) :: value(:, :)    !! (ncomp, n)
    real(wp) :: largest
    type(surface_basis_t), allocatable :: grid(:) ! functions on the grid of points
    real(wp), allocatable :: shp(:), dshp(:, :)
    real(wp) :: xi(NGRID)
    integer :: e, i, j, k, n

    largest = 0.0_wp
    xi = [(real(2*i - NGRID - 1, wp)/real(NGRID - 1, wp), i=1, NGRID)]
    allocate (grid(size(surface%basis)))
    do k = 1, size(grid)
      n = surface%basis(k)%nsf
      allocate (grid(k)%shp(n, NGRID**2), grid(k)%dshp(2, n, NGRID**2))
      do j = 1, NGRID
        do i = 1, NGRID
          n = (j - 1)*NGRID + i
          call surface_functions_at(surface%basis(k), [xi(i), xi(j)], grid(k)%shp(:, n), &
                                    grid(k)%dshp(:, :, n))
        end do
      end do
    end do
    do e = 1, surface%nelem
      associate (first => surface%first(e), last => surface%first(e + 1) - 1, &
                 table => grid(surface%ibasis(e)))
        associate (mine => at(first:last))
          if (all(abs(value(:, mine)) <= 0.0_wp)) cycle
          do i = 1, NGRID**2
            shp = table%shp(:, i)
            dshp = table%dshp(:, :, i)
            if (allocated(surface%w)) call make_rational(surface%w(first:last), shp, dshp)
            largest = max(largest, norm2(matmul(value(:, mine), shp)))
          end do
        end associate
      end associate
    end do
  end function largest_of

end module contact_smooth
