!> Uses an NPATch as the geometry of a PATCh, or makes it a body of its own on the given control
!! points.
module input_npatch
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text, lower
  use bspline, only: spline_t, extraction
  use element_table, only: load_elements
  use element_type, only: element_t, cell_t
  use few_points, only: warn_few_nurbs_points
  use hexa_shape, only: tensor_rule
  use input_doubts, only: twist, TURNED
  use input_draft, only: draft_t, npatch_entry_t
  use mesh, only: mesh_t, block_t, body_t, operator_t, append_blocks, append_body
  use nurbs, only: nurbs_t, is_rational
  use patch_nurbs, only: check_nurbs, check_orientation, turn_right_handed
  use word_material, only: material_index
  implicit none
  private
  public :: npatch_geometry, append_npatch, npatch_name, npatch_named

contains

  !> Name by which FIX and other records refer to the k-th NPATch.
  pure function npatch_name(k) result(name)
    integer, intent(in) :: k
    character(:), allocatable :: name

    name = 'npatch'//to_text(k)
  end function npatch_name

  !> Number of the NPATch of that name, whatever its case; 0: there is none.
  pure integer function npatch_named(draft, name) result(k)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: name

    do k = size(draft%npatch), 1, -1
      if (npatch_name(k) == lower(name)) return
    end do
  end function npatch_named

  !> Get the knot vectors and control points of an NPATch. The degree is the multiplicity of
  !! the first knot minus 1.
  subroutine npatch_geometry(draft, k, patch, error)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: k
    type(nurbs_t), intent(out) :: patch
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i, j, l, n
    real(wp) :: w

    associate (p => draft%npatch(k), nodes => draft%nodes)
      do d = 1, 3
        do i = size(draft%knots), 1, -1
          if (draft%knots(i)%number == p%knot(d) .and. p%knot(d) > 0) exit
        end do
        if (i == 0) then
          call fail(error, DECK_ERROR, 'knot vector '//to_text(p%knot(d)) &
                    //' of the NPATch is not defined', p%place, &
                    "define it with a record 'open id len k1 k2 ...' of KNOTs")
          return
        end if
        patch%dir(d)%knots = draft%knots(i)%u
        patch%dir(d)%degree = count(patch%dir(d)%knots <= patch%dir(d)%knots(1)) - 1
      end do
      allocate (patch%cp(4, p%n(1), p%n(2), p%n(3)))
      do l = 1, p%n(3)
        do j = 1, p%n(2)
          do i = 1, p%n(1)
            n = p%node(i, j, l)
            if (n <= nodes%top) then
              if (.not. nodes%given(n)) n = nodes%top + 1
            end if
            if (n > nodes%top) then
              call fail(error, DECK_ERROR, 'NPATch refers to control point ' &
                        //to_text(p%node(i, j, l))//', which is not defined', p%place, &
                        'define it with NURBs')
              return
            end if
            w = nodes%weight(n)
            if (.not. w > 0.0_wp) w = 1.0_wp
            patch%cp(:, i, j, l) = [w*nodes%x(:, n), w]
          end do
        end do
      end do
      call check_nurbs(patch, 3, 'NPATch '//to_text(k), p%place, error)
      if (.not. allocated(error)) call warn_twisted_layers(patch, p)
    end associate
  end subroutine npatch_geometry

  !> Warn if a layer of control points is turned by about 90 degrees against the layer before it;
  !! its list probably begins at another corner.
  subroutine warn_twisted_layers(patch, entry)
    type(nurbs_t), intent(in) :: patch
    type(npatch_entry_t), intent(in) :: entry
    integer, parameter :: AT_CORNER(8) = [0, 1, 3, 2, 4, 5, 7, 6] ! bit d-1: high in direction d
    real(wp) :: angle(3)
    integer :: d, i, low(3), high(3), n(3)

    n = shape(entry%node)
    do d = 1, 3
      do i = 1, n(d) - 1
        low = 1
        high = n
        low(d) = i
        high(d) = i + 1
        angle = twist(corners(low, high))
        if (angle(d) < TURNED) cycle
        call warn('this NPATch is twisted: layer '//to_text(i + 1)//' of its control points in ' &
                  //'direction '//to_text(d)//' is rotated by '//to_text(angle(d), 3) &
                  //' degrees relative to layer '//to_text(i), entry%place, &
                  'list the control points of all layers in the same order')
        return
      end do
    end do

  contains

    !> Corners of two layers, in the order of the nodes of a hexahedron.
    pure function corners(low, high) result(x)
      integer, intent(in) :: low(3), high(3)
      real(wp) :: x(3, 8)
      integer :: at(3), c

      do c = 1, 8
        at = merge(high, low, btest(AT_CORNER(c), [0, 1, 2]))
        x(:, c) = patch%cp(:3, at(1), at(2), at(3))/patch%cp(4, at(1), at(2), at(3))
      end do
    end function corners

  end subroutine warn_twisted_layers

  !> Append NPATch k to the mesh, as a body with one block of elements on its control points.
  subroutine append_npatch(draft, k, mesh, error)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: k
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(nurbs_t) :: patch
    type(block_t) :: block
    type(body_t) :: body
    integer, allocatable :: mask(:, :, :), elem(:, :, :)
    integer, allocatable :: node(:, :, :)
    logical :: turned
    integer :: n(3), b, d, e, f, last

    call npatch_geometry(draft, k, patch, error)
    if (allocated(error)) return
    call turn_right_handed(patch, turned)
    call check_orientation(patch, npatch_name(k), draft%npatch(k)%place, error)
    if (allocated(error)) return
    node = draft%npatch(k)%node
    if (turned) then
      node = node(:, :, size(node, 3):1:-1)
      call log_line('NPATch    '//npatch_name(k)//' is left-handed: its direction 3 is reversed ' &
                    //'internally, but faces keep their names')
    end if
    block%body = size(mesh%body) + 1
    body%name = npatch_name(k)
    body%place = draft%npatch(k)%place
    call fill_block(draft, k, patch, node, block)
    last = 0
    do b = 1, size(mesh%block)
      last = max(last, maxval(mesh%block(b)%number))
    end do
    block%number = block%number + last
    n = shape(node)
    allocate (mask(n(1), n(2), n(3)), source=0) ! bits of the faces on which a control point lies
    mask(1, :, :) = ibset(mask(1, :, :), 0)
    mask(n(1), :, :) = ibset(mask(n(1), :, :), 1)
    mask(:, 1, :) = ibset(mask(:, 1, :), 2)
    mask(:, n(2), :) = ibset(mask(:, n(2), :), 3)
    mask(:, :, 1) = ibset(mask(:, :, 1), merge(5, 4, turned))
    mask(:, :, n(3)) = ibset(mask(:, :, n(3)), merge(4, 5, turned))
    body%node = reshape(node, [size(node)])
    body%mask = reshape(mask, [size(mask)])
    do d = 1, 3
      associate (u => patch%dir(d)%knots)
        n(d) = count(u(2:) > u(:size(u) - 1)) ! number of elements
      end associate
    end do
    elem = reshape([(e, e=1, block%nelem)], n)
    body%face(1)%elem = reshape(elem(1, :, :), [n(2)*n(3)])
    body%face(2)%elem = reshape(elem(n(1), :, :), [n(2)*n(3)])
    body%face(3)%elem = reshape(elem(:, 1, :), [n(1)*n(3)])
    body%face(4)%elem = reshape(elem(:, n(2), :), [n(1)*n(3)])
    body%face(merge(6, 5, turned))%elem = reshape(elem(:, :, 1), [n(1)*n(2)])
    body%face(merge(5, 6, turned))%elem = reshape(elem(:, :, n(3)), [n(1)*n(2)])
    do f = 1, 6
      associate (face => body%face(f))
        allocate (face%block(size(face%elem)), source=size(mesh%block) + 1)
        allocate (face%side(size(face%elem)), source=merge(11 - f, f, turned .and. f > 4))
      end associate
    end do
    call append_blocks(mesh%block, [block])
    call append_body(mesh, body)
    mesh%is_control(body%node) = .true.
  end subroutine append_npatch

  !> Make one element for each box of nonempty knot spans; direction 1 varies fastest.
  subroutine fill_block(draft, k, patch, node, block)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: k
    type(nurbs_t), intent(in) :: patch
    integer, intent(in) :: node(:, :, :) !! control points of the NPATch
    type(block_t), intent(inout) :: block
    integer, allocatable :: first1(:), first2(:), first3(:), iop1(:), iop2(:), iop3(:)
    type(element_t), allocatable :: rows(:)
    type(cell_t) :: cell
    integer :: e, i, j, l, p(3)

    call load_elements(rows)
    do i = 1, size(rows)
      if (rows(i)%name == 'IGA') block%row = rows(i)
    end do
    p = patch%dir%degree
    allocate (block%ext%op(0))
    call add_operators(patch%dir(1), block%ext%op, first1, iop1)
    call add_operators(patch%dir(2), block%ext%op, first2, iop2)
    call add_operators(patch%dir(3), block%ext%op, first3, iop3)
    block%name = 'IGA'//to_text(maxval(p))
    block%material = material_index(draft, draft%npatch(k)%material)
    block%ext%degree = p
    block%nen = product(p + 1)
    block%nelem = size(iop1)*size(iop2)*size(iop3)
    allocate (block%conn(block%nen, block%nelem), block%ext%iop(3, block%nelem))
    if (is_rational(patch)) allocate (block%ext%w(block%nen, block%nelem))
    e = 0
    do l = 1, size(iop3)
      do j = 1, size(iop2)
        do i = 1, size(iop1)
          e = e + 1
          block%ext%iop(:, e) = [iop1(i), iop2(j), iop3(l)]
          associate (a => first1(i), b => first2(j), c => first3(l))
            block%conn(:, e) = reshape(node(a:a + p(1), b:b + p(2), c:c + p(3)), [block%nen])
            if (allocated(block%ext%w)) block%ext%w(:, e) = &
              reshape(patch%cp(4, a:a + p(1), b:b + p(2), c:c + p(3)), [block%nen])
          end associate
        end do
      end do
    end do
    block%number = [(e, e=1, block%nelem)]
    associate (q => draft%model%material(block%material)%nurbs_points)
      cell%degree = p
      if (all(q > 0)) then
        call tensor_rule(q, 0, 0, block%rule)
        call warn_few_nurbs_points(q, p, shape(node), [size(iop1), size(iop2), size(iop3)], &
                                   npatch_name(k), draft%npatch(k)%place)
      else
        call block%row%rule(cell, 0, 0, block%rule)
      end if
    end associate
  end subroutine fill_block

  !> Add the extraction operators of a spline; equal ones are stored once.
  subroutine add_operators(s, op, first, iop)
    type(spline_t), intent(in) :: s
    type(operator_t), allocatable, intent(inout) :: op(:)
    integer, allocatable, intent(out) :: first(:) !! first function of each element
    integer, allocatable, intent(out) :: iop(:)   !! operator of each element
    real(wp), parameter :: SAME = 16*epsilon(1.0_wp)
    type(operator_t), allocatable :: longer(:)
    real(wp), allocatable :: c(:, :, :)
    integer :: e, i

    call extraction(s, c, first)
    allocate (iop(size(first)))
    do e = 1, size(first)
      do i = size(op), 1, -1
        if (size(op(i)%c, 1) /= s%degree + 1) cycle
        if (maxval(abs(op(i)%c - c(:, :, e))) <= SAME) exit
      end do
      if (i == 0) then
        allocate (longer(size(op) + 1))
        longer(:size(op)) = op
        longer(size(longer))%c = c(:, :, e)
        call move_alloc(longer, op)
        i = size(op)
      end if
      iop(e) = i
    end do
  end subroutine add_operators

end module input_npatch
