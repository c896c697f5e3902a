!> Surfaces of CSURface and CBOUndary: finds the nodes near a nine-node surface, and applies its
!! pressure to element faces.
!!
!! The sign is FEAP's: a positive pressure acts along the normal of the surface (points 1 2 3 4
!! counter-clockwise). This must be the outward normal of the faces, so a positive pressure pulls.
!!
!! Source: FEAPpv's manual
module input_surface
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use boundary, only: boundary_t
  use element_type, only: cell_t, topology_t
  use face_rule, only: face_points, face_normal, face_directions
  use input_draft, only: condition_entry_t
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use mesh_boundary, only: find_outer_faces
  use quadrature, only: gauss_quad
  use tensor, only: cross
  use word_position, only: R_CBOU
  implicit none
  private
  public :: mark_surface, load_surface

  !> FEAP's gap is the larger of two lengths: BOX_GAP times the sum of the extents of the surface,
  !! and SIZE_GAP times its largest extent divided by the cube root of the number of nodes.
  real(wp), parameter :: BOX_GAP = 1.0e-4_wp
  real(wp), parameter :: SIZE_GAP = 1.0e-3_wp
  real(wp), parameter :: OUTSIDE = 1.0e-4_wp   !! distance outside the boundary, in parameters, that
  !! still counts as inside
  real(wp), parameter :: ALIGNED = 0.8_wp      !! smallest cosine of the angle between the normals
  real(wp), parameter :: LEAST_SHARE = 0.9_wp, MOST_SHARE = 1.1_wp !! smallest and largest loaded
  !! share of the area without a warning
  integer, parameter :: MAX_ITER = 100
  !> Signs of the coordinates of FEAP's nine points in the parameter plane of the surface.
  integer, parameter :: AT1(9) = [-1, 1, 1, -1, 0, 1, 0, -1, 0], &
                        AT2(9) = [-1, -1, 1, 1, -1, 0, 1, 0, 0]

  !> Marks of the faces of a block.
  type :: marks_t
    logical, allocatable :: face(:, :)         !! (6, nelem)
  end type marks_t

contains

  !> Mark the nodes on the surface.
  subroutine mark_surface(mesh, r, active, on)
    type(mesh_t), intent(in) :: mesh
    type(condition_entry_t), intent(in) :: r
    logical, intent(in) :: active(:)
    logical, allocatable, intent(out) :: on(:)
    real(wp) :: low(3), high(3), gap, xi(2), normal(3)
    integer :: n

    allocate (on(mesh%nnode))
    call search_box(r, mesh%nnode, low, high, gap)
    do n = 1, mesh%nnode
      on(n) = active(n)
      if (on(n)) on(n) = all(mesh%xr(:, n) >= low) .and. all(mesh%xr(:, n) <= high)
      if (on(n)) call project(r%surface, mesh%xr(:, n), gap, xi, normal, on(n))
    end do
    if (r%word == R_CBOU) call mark_faces(mesh, r, on)
  end subroutine mark_surface

  !> Mark all nodes of those outer faces of elements that have their corners on the surface and lie
  !! along it. On a curved surface the control points of a face lie off it, and so do the middle
  !! nodes of faces with straight edges.
  subroutine mark_faces(mesh, r, on)
    type(mesh_t), intent(in) :: mesh
    type(condition_entry_t), intent(in) :: r
    logical, intent(inout) :: on(:) !! (nnode) nodes on the surface
    type(marks_t), allocatable :: outer(:)
    type(topology_t) :: topology
    type(cell_t) :: cell
    logical, allocatable :: near(:)
    integer :: b, e, f

    if (.not. any(mesh%block%row%spline .or. mesh%block%nen > 8)) return
    allocate (near, source=on)
    call mark_outer(mesh, outer)
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        if (.not. any(outer(b)%face(:, e))) cycle
        if (.not. is_near(mesh, mesh%block(b), e, r, near)) cycle
        call block_cell(mesh%block(b), e, cell)
        call mesh%block(b)%row%topology(cell, topology)
        if (topology%nface /= 6) cycle
        do f = 1, 6
          if (.not. outer(b)%face(f, e)) cycle
          if (.not. has_corners_on(mesh, mesh%block(b), e, f, cell, r)) cycle
          if (.not. lies_along(mesh, mesh%block(b), e, f, cell, r)) cycle
          associate (node => topology%node(topology%first(f):topology%first(f + 1) - 1))
            on(mesh%block(b)%conn(node, e)) = .true.
          end associate
        end do
      end do
    end do
  end subroutine mark_faces

  !> Do all corners of face f of element e lie on the surface?
  logical function has_corners_on(mesh, block, e, f, cell, r) result(lie)
    type(mesh_t), intent(in) :: mesh
    type(block_t), intent(in) :: block
    integer, intent(in) :: e, f
    type(cell_t), intent(in) :: cell
    type(condition_entry_t), intent(in) :: r
    real(wp) :: corner(3, 4), low(3), high(3), gap, xi(2), normal(3), shp(block%nen), &
                dshp(3, block%nen)
    integer :: i

    call search_box(r, mesh%nnode, low, high, gap)
    corner = face_corners(f)
    do i = 1, 4
      call block%row%functions(cell, corner(:, i), shp, dshp)
      call project(r%surface, matmul(mesh%xr(:, block%conn(:, e)), shp), gap, xi, normal, lie)
      if (.not. lie) return
    end do
  end function has_corners_on

  !> Does face f of element e, whose corners lie on the surface, have the direction of the surface
  !! at its centre, and is it not farther from the surface, except by the gap, than the flat face
  !! with these corners? Both ends of an arch of one element can stand on a surface that its other
  !! faces leave.
  logical function lies_along(mesh, block, e, f, cell, r) result(along)
    type(mesh_t), intent(in) :: mesh
    type(block_t), intent(in) :: block
    integer, intent(in) :: e, f
    type(cell_t), intent(in) :: cell
    type(condition_entry_t), intent(in) :: r
    real(wp) :: corner(3, 4), centre(3), at(3), x(3, block%nen), flat(3, 4), shp(block%nen), &
                dshp(3, block%nen), share(4), low(3), high(3), gap, area(3), t1(3), t2(3), &
                normal(3), eta(2)
    logical :: lies
    integer :: i, j

    call search_box(r, mesh%nnode, low, high, gap)
    x = mesh%xr(:, block%conn(:, e))
    corner = face_corners(f)
    do i = 1, 4
      call block%row%functions(cell, corner(:, i), shp, dshp)
      flat(:, i) = matmul(x, shp)
    end do
    centre = 0.25_wp*sum(corner, 2)
    call block%row%functions(cell, centre, shp, dshp)
    call face_normal(f, x, dshp, area, t1, t2)
    call project(r%surface, matmul(x, shp), huge(1.0_wp), eta, normal, lies)
    along = abs(dot_product(area, normal)) > ALIGNED*norm2(area)*norm2(normal)
    do i = 0, 4
      if (.not. along) return
      at = centre
      if (i > 0) at = 0.5_wp*(centre + corner(:, i)) ! halfway to a corner
      do j = 1, 4
        share(j) = 0.125_wp*product(1.0_wp + at*corner(:, j))
      end do
      call block%row%functions(cell, at, shp, dshp)
      along = distance(r%surface, matmul(x, shp)) &
              < gap + distance(r%surface, matmul(flat, share))
    end do
  end function lies_along

  !> Parent coordinates of the corners of a face of a hexahedron.
  pure function face_corners(f) result(corner)
    integer, intent(in) :: f
    real(wp) :: corner(3, 4)
    integer :: a, b, k

    call face_directions(f, k, a, b)
    corner(k, :) = merge(-1.0_wp, 1.0_wp, mod(f, 2) == 1)
    corner(a, :) = [-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp]
    corner(b, :) = [-1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp]
  end function face_corners

  !> Find the gap, which is FEAP's unless the record gives another one, and the bounding box of the
  !! surface, enlarged on each side by 1.5 times the gap.
  pure subroutine search_box(r, nnode, low, high, gap)
    type(condition_entry_t), intent(in) :: r
    integer, intent(in) :: nnode
    real(wp), intent(out) :: low(3), high(3), gap

    low = minval(r%surface(:3, :), 2)
    high = maxval(r%surface(:3, :), 2)
    if (r%gap > 0.0_wp) then
      gap = r%gap
    else
      gap = max(BOX_GAP*sum(high - low), SIZE_GAP*maxval(high - low) &
                /real(nnode, wp)**(1.0_wp/3.0_wp))
    end if
    low = low - 1.5_wp*gap
    high = high + 1.5_wp*gap
  end subroutine search_box

  !> Project a point onto the closest point of the surface, by the Gauss-Newton method. `on` is true
  !! if the distance is less than the gap and the projection lies inside the boundary.
  pure subroutine project(surface, x, gap, xi, normal, on)
    real(wp), intent(in) :: surface(:, :) !! (4, 9)
    real(wp), intent(in) :: x(3), gap
    real(wp), intent(out) :: xi(2), normal(3)
    logical, intent(out) :: on
    real(wp) :: f(9), d(2, 9), t1(3), t2(3), dx(3), r(2), a(2, 2), det, step(2)
    integer :: it

    xi = 0.0_wp
    on = .false.
    normal = 0.0_wp
    do it = 1, MAX_ITER
      call functions(xi, f, d)
      dx = matmul(surface(:3, :), f) - x
      t1 = matmul(surface(:3, :), d(1, :))
      t2 = matmul(surface(:3, :), d(2, :))
      r = [dot_product(dx, t1), dot_product(dx, t2)]
      a = reshape([dot_product(t1, t1), dot_product(t1, t2), dot_product(t1, t2), &
                   dot_product(t2, t2)], [2, 2])
      det = a(1, 1)*a(2, 2) - a(1, 2)**2
      if (.not. det > epsilon(det)*a(1, 1)*a(2, 2)) return
      step = -[a(2, 2)*r(1) - a(1, 2)*r(2), a(1, 1)*r(2) - a(1, 2)*r(1)]/det
      xi = xi + step
      if (maxval(abs(step)) < 1.0e-10_wp) exit
      if (maxval(abs(xi)) > 10.0_wp) return
    end do
    normal = cross(t1, t2)
    on = norm2(dx) < gap .and. maxval(abs(xi)) < 1.0_wp + OUTSIDE
  end subroutine project

  !> Distance of a point from the surface, which is continued beyond its boundary [L].
  pure real(wp) function distance(surface, x)
    real(wp), intent(in) :: surface(:, :) !! (4, 9)
    real(wp), intent(in) :: x(3)
    real(wp) :: xi(2), normal(3), f(9), d(2, 9)
    logical :: on

    call project(surface, x, huge(1.0_wp), xi, normal, on)
    call functions(xi, f, d)
    distance = norm2(matmul(surface(:3, :), f) - x)
  end function distance

  !> Biquadratic functions of the nine points and their derivatives.
  pure subroutine functions(xi, f, d)
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: f(9), d(2, 9)
    real(wp) :: g1(-1:1), g2(-1:1), d1(-1:1), d2(-1:1)
    integer :: a

    g1 = [0.5_wp*xi(1)*(xi(1) - 1.0_wp), 1.0_wp - xi(1)**2, 0.5_wp*xi(1)*(xi(1) + 1.0_wp)]
    g2 = [0.5_wp*xi(2)*(xi(2) - 1.0_wp), 1.0_wp - xi(2)**2, 0.5_wp*xi(2)*(xi(2) + 1.0_wp)]
    d1 = [xi(1) - 0.5_wp, -2.0_wp*xi(1), xi(1) + 0.5_wp]
    d2 = [xi(2) - 0.5_wp, -2.0_wp*xi(2), xi(2) + 0.5_wp]
    do a = 1, 9
      f(a) = g1(AT1(a))*g2(AT2(a))
      d(:, a) = [d1(AT1(a))*g2(AT2(a)), g1(AT1(a))*d2(AT2(a))]
    end do
  end subroutine functions

  !> Add the forces of the pressure on those outer faces of elements whose corners all lie on the
  !! surface. Faces between two bodies or two materials count as outer faces, and so do faces that
  !! TIE joins.
  subroutine load_surface(mesh, r, on, new, bc, error)
    type(mesh_t), intent(in) :: mesh
    type(condition_entry_t), intent(in) :: r
    logical, intent(in) :: on(:)  !! (nnode) nodes on the surface
    integer, intent(in) :: new(:) !! (nnode) the node that replaces each node after TIE
    type(boundary_t), intent(inout) :: bc
    type(error_t), allocatable, intent(out) :: error
    type(marks_t), allocatable :: outer(:)
    type(topology_t) :: topology
    type(cell_t) :: cell
    real(wp) :: loaded, whole
    integer :: b, e, f, ninner

    call mark_outer(mesh, outer)
    loaded = 0.0_wp
    ninner = 0
    do b = 1, size(mesh%block)
      do e = 1, mesh%block(b)%nelem
        if (.not. is_near(mesh, mesh%block(b), e, r, on)) cycle
        call block_cell(mesh%block(b), e, cell)
        call mesh%block(b)%row%topology(cell, topology)
        if (topology%nface /= 6) cycle
        do f = 1, 6
          call load_face(mesh, mesh%block(b), e, f, cell, r, new, outer(b)%face(f, e), bc, loaded, &
                         ninner)
        end do
      end do
    end do
    whole = area_of(r%surface)
    if (loaded > 0.0_wp) then
      if (loaded < LEAST_SHARE*whole) then
        call warn('the pressure acts on only '//to_text(100*loaded/whole, 3)//' % of the area of ' &
                  //'its surface', r%place, 'a pressure acts on whole outer faces of elements: ' &
                  //'give a surface whose edges are edges of elements, or widen the search with ' &
                  //'GAP d')
      else if (loaded > MOST_SHARE*whole) then
        call warn('the pressure acts on '//to_text(loaded/whole, 3)//' times the area of its ' &
                  //'surface: faces that lie behind each other are within GAP', r%place, &
                  'give a smaller distance with GAP, or use PRESsure')
      end if
    else if (ninner > 0) then
      call fail(error, DECK_ERROR, 'the surface lies inside a body: each element face on it ' &
                //'belongs to two elements (number: '//to_text(ninner)//')', r%place, 'a ' &
                //'pressure acts ' &
                //'on the outer faces of a body; FORCe and EFORce load nodes inside')
    else
      call fail(error, DECK_ERROR, 'no element face lies on the surface', r%place, 'number its ' &
                //'points 1 2 3 4 counter-clockwise as seen from outside, or widen the search ' &
                //'with GAP d')
    end if
  end subroutine load_surface

  !> Can an element have a face on the surface? An element with nodes at its corners needs three
  !! nodes on the surface. Control points of splines need not lie on it even if the corners of the
  !! element do, but the element lies within the bounding box of its control points.
  pure logical function is_near(mesh, block, e, r, on) result(near)
    type(mesh_t), intent(in) :: mesh
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    type(condition_entry_t), intent(in) :: r
    logical, intent(in) :: on(:)  !! (nnode) nodes on the surface
    real(wp) :: low(3), high(3), gap

    if (.not. block%row%spline) then
      near = count(on(block%conn(:, e))) >= 3
      return
    end if
    near = .false.
    if (is_rigid(block)) return
    call search_box(r, mesh%nnode, low, high, gap)
    associate (x => mesh%xr(:, block%conn(:, e)))
      near = all(maxval(x, 2) >= low) .and. all(minval(x, 2) <= high)
    end associate
  end function is_near

  !> Mark the outer faces of all elements, as they are before TIE joins nodes.
  subroutine mark_outer(mesh, outer)
    type(mesh_t), intent(in) :: mesh
    type(marks_t), allocatable, intent(out) :: outer(:)
    integer, allocatable :: block(:), elem(:), side(:)
    integer :: b, i

    allocate (outer(size(mesh%block)))
    do b = 1, size(mesh%block)
      allocate (outer(b)%face(6, mesh%block(b)%nelem), source=.false.)
    end do
    call find_outer_faces(mesh, block, elem, side, by_material=.true.)
    do i = 1, size(block)
      outer(block(i))%face(side(i), elem(i)) = .true.
    end do
  end subroutine mark_outer

  !> Area of a surface of nine points, by 5 x 5 Gauss points in each quarter [L^2].
  real(wp) function area_of(surface) result(area)
    real(wp), intent(in) :: surface(:, :) !! (4, 9)
    real(wp) :: xi(2, 25), w(25), f(9), d(2, 9)
    integer :: i, j, q

    call gauss_quad(5, 5, xi, w)
    area = 0.0_wp
    do i = -1, 1, 2
      do j = -1, 1, 2
        do q = 1, size(w)
          call functions(0.5_wp*(xi(:, q) + [i, j]), f, d)
          area = area + 0.25_wp*w(q)*norm2(cross(matmul(surface(:3, :), d(1, :)), &
                                                 matmul(surface(:3, :), d(2, :))))
        end do
      end do
    end do
  end function area_of

  !> Add the forces on one outer face if its corners lie on the surface and its normal is aligned
  !! with that of the surface. The pressure at an integration point is that of the surface at the
  !! closest point.
  subroutine load_face(mesh, block, e, f, cell, r, new, is_outer, bc, loaded, ninner)
    type(mesh_t), intent(in) :: mesh
    type(block_t), intent(in) :: block
    integer, intent(in) :: e, f
    type(cell_t), intent(in) :: cell
    type(condition_entry_t), intent(in) :: r
    integer, intent(in) :: new(:)
    logical, intent(in) :: is_outer           !! if false, the face is counted, but not loaded
    type(boundary_t), intent(inout) :: bc
    real(wp), intent(inout) :: loaded         !! area of the faces [L^2]
    integer, intent(inout) :: ninner
    real(wp), allocatable :: xi(:, :), w(:), shp(:), dshp(:, :), x(:, :)
    real(wp) :: centre(3), area(3), t1(3), t2(3), normal(3), load, eta(2), g(9), d(2, 9)
    logical :: lies
    integer :: q, i

    if (.not. has_corners_on(mesh, block, e, f, cell, r)) return
    allocate (x, source=mesh%xr(:, block%conn(:, e)))
    allocate (shp(block%nen), dshp(3, block%nen))
    centre = 0.25_wp*sum(face_corners(f), 2)
    call block%row%functions(cell, centre, shp, dshp)
    call face_normal(f, x, dshp, area, t1, t2)
    call project(r%surface, matmul(x, shp), huge(load), eta, normal, lies)
    if (.not. dot_product(area, normal) > ALIGNED*norm2(area)*norm2(normal)) return
    if (.not. is_outer) then
      ninner = ninner + 1
      return
    end if
    call face_points(cell%degree, block%rule%xi, f, xi, w, order=2)
    do q = 1, size(w)
      call block%row%functions(cell, xi(:, q), shp, dshp)
      call face_normal(f, x, dshp, area, t1, t2)
      loaded = loaded + w(q)*norm2(area)
      call project(r%surface, matmul(x, shp), huge(load), eta, normal, lies)
      call functions(eta, g, d)
      load = w(q)*dot_product(g, r%surface(4, :))
      do i = 1, block%nen
        associate (n => new(block%conn(i, e)))
          bc%force(:, n) = bc%force(:, n) + load*shp(i)*area
        end associate
      end do
    end do
  end subroutine load_face

end module input_surface
