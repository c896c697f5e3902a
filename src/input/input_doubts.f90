!> Warnings about models that can be solved but are probably not intended: elements in the same
!! place (an error if they also have the same nodes and material), twisted elements, and elements
!! that lock or have other large errors.
module input_doubts
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_sort, only: sort, sort_index
  use base_text, only: quoted, to_text
  use elastic_constants, only: NU
  use element_type, only: cell_t, topology_t
  use input_draft, only: draft_t
  use model, only: material_set_t
  use mesh, only: mesh_t, block_cell, is_rigid
  use tensor, only: cross
  implicit none
  private
  public :: check_twice, warn_twisted, warn_locking, twist, TURNED
  public :: member_t, list_members, element_text, place_of, shortest, NEAR

  real(wp), parameter :: NEAR = 1.0e-6_wp     !! positions closer than this times `size` are equal
  !> Smallest Poisson's ratios that cause a warning: LOCKING_FROM for linear elements, which lock;
  !! SOFT_FROM for quadratic elements and enhanced layers, and STIFF_FROM for Q1E9, because their
  !! errors are then 10 % or more.
  real(wp), parameter :: LOCKING_FROM = 0.49_wp, SOFT_FROM = 0.498_wp, STIFF_FROM = 0.4995_wp

  real(wp), parameter :: DEGREE = acos(-1.0_wp)/180.0_wp
  real(wp), parameter :: TURNED = 70.0_wp !! a larger twist is hardly intended [degrees]
  !> A line of a face has no meaningful direction if its length, relative to that of the longest
  !! line of the two faces, is less than this.
  real(wp), parameter :: FLAT = 0.05_wp

  !> An element of any block.
  type :: member_t
    integer :: block = 0, elem = 0
    real(wp) :: centre(3) = 0.0_wp, size = 0.0_wp !! size: shortest distance between nodes [L]
  end type member_t

contains

  !> Reject elements of one material that have the same nodes, and warn about elements in the same
  !! place, because the stiffness is added twice there.
  subroutine check_twice(draft, mesh)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error
    type(member_t), allocatable :: list(:)
    real(wp), allocatable :: key(:)
    integer, allocatable :: order(:)
    integer, allocatable :: first(:), second(:)
    integer :: i, j, nplace
    logical :: same

    call list_members(mesh, list)
    if (size(list) < 2) return
    allocate (key(size(list)), order(size(list)))
    do i = 1, size(list) ! position along a direction in which centres seldom coincide
      key(i) = dot_product(list(i)%centre, [1.0_wp, 0.7320508075688772_wp, 0.4142135623730951_wp])
    end do
    call sort_index(key, order)
    nplace = 0
    do i = 1, size(order)
      associate (a => list(order(i)))
        do j = i + 1, size(order)
          associate (b => list(order(j)))
            if (key(order(j)) - key(order(i)) > 2*NEAR*a%size) exit
            if (any(abs(a%centre - b%centre) > NEAR*a%size)) cycle
            if (abs(a%size - b%size) > NEAR*a%size) cycle
            first = nodes_of(mesh, a)
            second = nodes_of(mesh, b)
            if (size(first) /= size(second)) cycle
            same = all(first == second)
            if (same .and. mesh%block(a%block)%material == mesh%block(b%block)%material) then
              call fail(error, DECK_ERROR, element_text(mesh, b)//' has the same nodes as ' &
                        //element_text(mesh, a), place_of(draft, mesh, b), 'remove one of them: ' &
                        //'the stiffness would count twice')
              call draft%errors%add(error)
              return
            end if
            if (.not. same) same = same_positions(mesh, first, second, NEAR*a%size)
            if (same) nplace = nplace + 1
            if (same .and. nplace == 1) then
              call warn(element_text(mesh, b)//' lies in the same place as ' &
                        //element_text(mesh, a), place_of(draft, mesh, b), &
                        'remove one of them, unless the stiffness is meant to count twice there')
            end if
          end associate
        end do
      end associate
    end do
  end subroutine check_twice

  !> List all elements that deform, with the centre of their nodes and the shortest distance between
  !! nodes.
  subroutine list_members(mesh, list)
    type(mesh_t), intent(in) :: mesh
    type(member_t), allocatable, intent(out) :: list(:)
    integer :: b, e, n

    n = 0
    do b = 1, size(mesh%block)
      if (.not. is_rigid(mesh%block(b))) n = n + mesh%block(b)%nelem
    end do
    allocate (list(n))
    n = 0
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        n = n + 1
        associate (x => mesh%xr(:, mesh%block(b)%conn(:, e)))
          list(n)%block = b
          list(n)%elem = e
          list(n)%centre = sum(x, 2)/size(x, 2)
          list(n)%size = shortest(x)
        end associate
      end do
    end do
  end subroutine list_members

  !> Shortest distance between two nodes that do not coincide.
  pure real(wp) function shortest(x)
    real(wp), intent(in) :: x(:, :) !! (3, n) [L]
    real(wp) :: square
    integer :: i, j

    shortest = huge(1.0_wp)
    do i = 2, size(x, 2)
      do j = 1, i - 1
        square = sum((x(:, i) - x(:, j))**2)
        if (square > 0.0_wp) shortest = min(shortest, square)
      end do
    end do
    shortest = sqrt(shortest)
  end function shortest

  !> Nodes of an element in ascending order.
  function nodes_of(mesh, member) result(node)
    type(mesh_t), intent(in) :: mesh
    type(member_t), intent(in) :: member
    integer, allocatable :: node(:)

    node = mesh%block(member%block)%conn(:, member%elem)
    call sort(node)
  end function nodes_of

  !> Does every node of the first list have a node of the second list at its position?
  pure function same_positions(mesh, first, second, near) result(same)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: first(:), second(:)
    real(wp), intent(in) :: near
    logical :: same
    integer :: i, j

    same = .true.
    do i = 1, size(first)
      do j = 1, size(second)
        if (all(abs(mesh%xr(:, first(i)) - mesh%xr(:, second(j))) <= near)) exit
      end do
      same = j <= size(second)
      if (.not. same) return
    end do
  end function same_positions

  function element_text(mesh, member) result(text)
    type(mesh_t), intent(in) :: mesh
    type(member_t), intent(in) :: member
    character(:), allocatable :: text

    associate (block => mesh%block(member%block))
      text = 'element '//to_text(block%number(member%elem))
      if (block%body > 0) text = text//' of '//quoted(mesh%body(block%body)%name)
    end associate
  end function element_text

  function place_of(draft, mesh, member) result(place)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(member_t), intent(in) :: member
    type(place_t) :: place

    associate (block => mesh%block(member%block))
      if (block%body > 0) then
        place = mesh%body(block%body)%place
      else
        place = draft%places%at(draft%elements%place(block%number(member%elem)))
      end if
    end associate
  end function place_of

  !> Warn about hexahedra and wedges with opposite faces that are turned against each other, usually
  !! because the nodes of one face begin at a different corner from those of the other face. After a
  !! quarter of a turn, a hexahedron still has two thirds of its volume, and after a third of a
  !! turn, a wedge has half of it; their Jacobians are positive everywhere.
  subroutine warn_twisted(draft, mesh)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(cell_t) :: cell
    type(topology_t) :: topology
    type(member_t) :: first
    character(:), allocatable :: text, order
    real(wp) :: angle, largest
    integer :: b, e, n

    n = 0
    largest = 0.0_wp
    order = 'fifth node must lie opposite the first, the sixth opposite the second'
    do b = 1, size(mesh%block)
      associate (block => mesh%block(b))
        if (is_rigid(block) .or. block%row%spline .or. block%nelem == 0) cycle
        call block_cell(block, 1, cell)
        call block%row%topology(cell, topology)
        if (topology%shape /= 'hexahedron' .and. topology%shape /= 'wedge') cycle
        do e = 1, block%nelem
          associate (x => mesh%xr(:, block%conn(topology%corner, e)))
            if (size(x, 2) == 6) angle = turn(x(:, :3), x(:, 4:))
            if (size(x, 2) == 8) angle = maxval(twist(x))
          end associate
          if (angle < TURNED) cycle
          n = n + 1
          if (n > 1) cycle
          if (topology%shape == 'wedge') order = 'fourth node must lie opposite the first, the ' &
                                                 //'fifth opposite the second'
          largest = angle
          first%block = b
          first%elem = e
        end do
      end associate
    end do
    if (n == 0) return
    text = element_text(mesh, first)//' is twisted: opposite faces are rotated by ' &
           //to_text(largest, 3)//' degrees relative to each other'
    if (n > 1) text = text//' (the first of '//to_text(n)//' such elements)'
    call warn(text, place_of(draft, mesh, first), 'list the nodes of both faces in the same ' &
              //'order: the '//order)
  end subroutine warn_twisted

  !> Angle by which opposite faces of a hexahedron are turned against each other, about the line
  !! through their centres, for each of its three directions [degrees].
  pure function twist(x)
    real(wp), intent(in) :: x(:, :) !! (3, 8) corners [L]
    real(wp) :: twist(3)
    integer, parameter :: LOW(4, 3) = reshape([1, 4, 8, 5, 1, 5, 6, 2, 1, 2, 3, 4], [4, 3])
    integer, parameter :: HIGH(4, 3) = reshape([2, 3, 7, 6, 4, 8, 7, 3, 5, 6, 7, 8], [4, 3])
    real(wp) :: axis(3), p(3, 2, 2), cosine(2)
    integer :: d, i, k

    twist = 0.0_wp
    do d = 1, 3
      axis = sum(x(:, HIGH(:, d)) - x(:, LOW(:, d)), 2)
      if (.not. norm2(axis) > 0.0_wp) cycle
      axis = axis/norm2(axis)
      p(:, :, 1) = middle_lines(x(:, LOW(:, d)))
      p(:, :, 2) = middle_lines(x(:, HIGH(:, d)))
      do k = 1, 2
        do i = 1, 2
          p(:, i, k) = p(:, i, k) - dot_product(p(:, i, k), axis)*axis
        end do
      end do
      if (.not. minval(norm2(p, 1)) > FLAT*maxval(norm2(p, 1))) cycle
      do i = 1, 2
        cosine(i) = dot_product(p(:, i, 1), p(:, i, 2))/(norm2(p(:, i, 1))*norm2(p(:, i, 2)))
      end do
      twist(d) = acos(max(-1.0_wp, min(1.0_wp, maxval(cosine))))/DEGREE
    end do
  end function twist

  !> Angle of the rotation that best turns the edges of the lower face of a wedge into those of the
  !! upper one, seen along the line between their centres [degrees].
  pure real(wp) function turn(low, high)
    real(wp), intent(in) :: low(:, :), high(:, :) !! (3, 3) corners of the two faces [L]
    real(wp) :: a(3), axis(3), b(3), cosine, sine
    integer :: i

    turn = 0.0_wp
    axis = sum(high - low, 2)
    if (.not. norm2(axis) > 0.0_wp) return
    axis = axis/norm2(axis)
    cosine = 0.0_wp
    sine = 0.0_wp
    do i = 1, 3
      a = low(:, 1 + mod(i, 3)) - low(:, i)
      b = high(:, 1 + mod(i, 3)) - high(:, i)
      cosine = cosine + dot_product(a, b) - dot_product(a, axis)*dot_product(b, axis)
      sine = sine + dot_product(axis, cross(a, b))
    end do
    if (abs(cosine) + abs(sine) > 0.0_wp) turn = abs(atan2(sine, cosine))/DEGREE
  end function turn

  !> Lines between the middles of opposite edges of a quadrilateral.
  pure function middle_lines(x) result(line)
    real(wp), intent(in) :: x(:, :) !! (3, 4) corners in cyclic order [L]
    real(wp) :: line(3, 2)

    line(:, 1) = x(:, 2) - x(:, 1) + x(:, 3) - x(:, 4)
    line(:, 2) = x(:, 4) - x(:, 1) + x(:, 3) - x(:, 2)
  end function middle_lines

  !> Warn about nearly incompressible materials in elements that have large errors with them; once
  !! for each material.
  !!
  !! - Linear displacement elements lock. As an example, a cube of 3 x 3 x 3 elements with a
  !!   Poisson's ratio of 0.499 is squeezed between rough plates. The force on it, divided by that
  !!   of a fine mesh, is 16 with Q1, 1.1 with Q1E9 (even with a layer ENRIch ... EAS) and IGA 3,
  !!   1.2 with Q2, and 1.6 with IGA 2. The hints name neither IGA 2 nor layers ENRIch ... EAS on Q1
  !!   (7.5), where the elements below the layer lock.
  !! - Quadratic displacement elements have displacements that are a few percent too small, but
  !!   their pressure oscillates: in a quarter ring of 6 x 6 elements under pressure, the hoop
  !!   stress at a point is 1.1, 1.6, 2.2 and 12 times the exact one for ratios of 0.49, 0.498,
  !!   0.499 and 0.4999.
  !! - Curved layers ENRIch ... EAS are too soft: by 2, 11 and 25 % at the surface of this ring for
  !!   ratios of 0.49, 0.499 and 0.4999, and by 13 % for 0.4999 with 12 x 12 elements. Q1E9 alone
  !!   has an error of 0.6 %.
  !! - Q1E9 partly locks, because nine modes do not remove all volumetric locking in three
  !!   dimensions. A clamped beam of 20 x 2 x 2 elements bends by 10 and 18 % too little for ratios
  !!   of 0.499 and 0.4999, and by 7 % for 0.4999 with 40 x 4 x 4 elements; Hertz contact is 17 and
  !!   51 % too stiff.
  subroutine warn_locking(draft, mesh)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, allocatable :: warned(:)
    integer :: b

    allocate (warned(0))
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      associate (block => mesh%block(b), m => draft%model%material(mesh%block(b)%material))
        if (any(warned == m%number)) cycle
        if (block%row%nmode > 0) then
          if (.not. block%row%spline .or. m%prop(NU) < SOFT_FROM) cycle
          call doubt(m, block%name, 'may be too soft', 'use Q1E9 elements without an enriched or ' &
                     //"spline layer, or a smaller Poisson's ratio; refine to see the error")
        else if (linear(block%name)) then
          if (m%prop(NU) < LOCKING_FROM) cycle
          call doubt(m, block%name, 'lock', 'use hexahedra of TYPE Q1E9 (with ENRIch: EAS; with ' &
                     //'ELEMents and BLOCk: ENHAnced) or Q2, or tetrahedra of 10 nodes; ' &
                     //'elements that lock give displacements that are far too small')
        else if (block%name == 'IGA2') then
          if (m%prop(NU) < SOFT_FROM) cycle
          call doubt(m, block%name, 'partly lock and have stresses that oscillate', 'on coarse ' &
                     //'meshes, forces may be 60 % too large: refine to see the error, or use a ' &
                     //'higher degree, hexahedra of TYPE Q1E9 or Q2, or tetrahedra of 10 nodes')
        else
          if (m%prop(NU) < SOFT_FROM) cycle
          call doubt(m, block%name, 'have stresses that oscillate', 'do not trust stresses, and ' &
                     //'refine to see the error of displacements and forces, which may be 20 % ' &
                     //"on coarse meshes, or use a smaller Poisson's ratio")
        end if
        warned = [warned, m%number]
      end associate
    end do
    do b = 1, size(mesh%block) ! Q1E9, unless other elements of its material, with larger errors,
      ! have been named
      if (is_rigid(mesh%block(b))) cycle
      associate (block => mesh%block(b), m => draft%model%material(mesh%block(b)%material))
        if (block%row%nmode == 0 .or. block%row%spline .or. any(warned == m%number)) cycle
        if (m%prop(NU) < STIFF_FROM) cycle
        if (is_plane(block%conn, draft%model%bc%fixed)) cycle
        call doubt(m, block%name, 'partly lock', 'on coarse meshes, forces are 10 to 50 % too ' &
                   //'large in bending and contact: refine to see the error, or use TYPE Q2 for ' &
                   //'displacements and forces')
        warned = [warned, m%number]
      end associate
    end do
  end subroutine warn_locking

  !> Is a direction fixed at all nodes of the elements? In plane strain nine modes suffice.
  pure logical function is_plane(conn, fixed)
    integer, intent(in) :: conn(:, :)  !! (nen, nelem)
    integer, intent(in) :: fixed(:, :) !! (3, nnode) restraint codes
    logical :: always(3)
    integer :: e, i

    always = .true.
    do e = 1, size(conn, 2)
      do i = 1, size(conn, 1)
        always = always .and. fixed(:, conn(i, e)) /= 0
      end do
    end do
    is_plane = any(always)
  end function is_plane

  !> Warn about one kind of element with a nearly incompressible material.
  subroutine doubt(m, name, what, hint)
    type(material_set_t), intent(in) :: m
    character(*), intent(in) :: name !! name of the elements
    character(*), intent(in) :: what !! what these elements do
    character(*), intent(in) :: hint

    call warn(trim(name)//' elements '//what//', because material '//to_text(m%number) &
              //" has Poisson's ratio "//to_text(m%prop(NU)), m%place, hint)
  end subroutine doubt

  pure logical function linear(name)
    character(*), intent(in) :: name

    linear = index(name, 'Q1') == 1 .or. &
             any(name == ['TET4    ', 'WEDGE6  ', 'PYRAMID5', 'IGA1    '])
  end function linear

end module input_doubts
