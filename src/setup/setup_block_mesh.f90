!> Nodes and elements of a BLOCk: a mapped brick.
!!
!! Source: FEAPpv's manual
module setup_block_mesh
  use base_kinds, only: wp
  use elmt_q2, only: FEAP27
  use setup_build, only: build_t
  use setup_lists, only: grow_nodes, grow_elements
  implicit none
  private
  public :: block_spec_t, make_nodes, make_elements

  integer, parameter, public :: BRICK_8 = 10, BRICK_27 = 12 !! FEAP's block types

  !> Position of FEAP's 27 master nodes in tensor order; its element nodes are counted another way.
  integer, parameter :: MASTER27(27) = [1, 3, 9, 7, 19, 21, 27, 25, 10, 12, 18, 16, 2, 6, 8, 4, 5, &
                                        20, 24, 26, 22, 23, 11, 15, 17, 13, 14]

  !> What a BLOCk says.
  type :: block_spec_t
    integer :: n(3) = 0              !! increments of nodes
    integer :: node = 0, element = 0, material = 0, type = 0
    logical :: given(27) = .false.   !! master nodes
    real(wp) :: x(3, 27) = 0.0_wp    !! (3, 27) in FEAP's master order [L]
  end type block_spec_t

contains

  !> All 27 master nodes in tensor order: missing ones by FEAP's rules, straight edges first.
  pure subroutine fill_master(spec, x)
    type(block_spec_t), intent(in) :: spec
    real(wp), intent(out) :: x(3, 3, 3, 3) !! (3, i, j, k)
    real(wp) :: list(3, 27)
    logical :: given(27)
    integer :: i, j, k

    list(:, MASTER27) = spec%x
    given(MASTER27) = spec%given
    x = reshape(list, [3, 3, 3, 3])
    do k = 1, 3
      do j = 1, 3
        do i = 1, 3
          if (count([i, j, k] == 2) /= 1 .or. given(i + 3*(j - 1) + 9*(k - 1))) cycle
          if (i == 2) x(:, 2, j, k) = 0.5_wp*(x(:, 1, j, k) + x(:, 3, j, k))
          if (j == 2) x(:, i, 2, k) = 0.5_wp*(x(:, i, 1, k) + x(:, i, 3, k))
          if (k == 2) x(:, i, j, 2) = 0.5_wp*(x(:, i, j, 1) + x(:, i, j, 3))
        end do
      end do
    end do
    do i = 1, 3, 2
      if (.not. given(i + 12)) call fill_face(x(:, i, :, :))
      if (.not. given(3*i + 8)) call fill_face(x(:, :, i, :))
      if (.not. given(9*i - 4)) call fill_face(x(:, :, :, i))
    end do
    if (.not. given(14)) x(:, 2, 2, 2) = 0.25_wp*(sum_edges(x) - sum_corners(x))
  end subroutine fill_master

  !> Middle of a face: half the edges' middles less a quarter of the corners.
  pure subroutine fill_face(x)
    real(wp), intent(inout) :: x(3, 3, 3)

    x(:, 2, 2) = 0.5_wp*(x(:, 2, 1) + x(:, 1, 2) + x(:, 3, 2) + x(:, 2, 3)) &
                 - 0.25_wp*(x(:, 1, 1) + x(:, 3, 1) + x(:, 1, 3) + x(:, 3, 3))
  end subroutine fill_face

  !> Sum that FEAP takes for the middle of the block: edges of its lower and upper faces and the
  !! middles of the four side faces.
  pure function sum_edges(x) result(s)
    real(wp), intent(in) :: x(3, 3, 3, 3)
    real(wp) :: s(3)

    s = x(:, 2, 1, 1) + x(:, 3, 2, 1) + x(:, 2, 3, 1) + x(:, 1, 2, 1) &
        + x(:, 2, 1, 3) + x(:, 3, 2, 3) + x(:, 2, 3, 3) + x(:, 1, 2, 3) &
        + x(:, 2, 1, 2) + x(:, 3, 2, 2) + x(:, 2, 3, 2) + x(:, 1, 2, 2)
  end function sum_edges

  pure function sum_corners(x) result(s)
    real(wp), intent(in) :: x(3, 3, 3, 3)
    real(wp) :: s(3)

    s = sum(sum(sum(x(:, 1:3:2, 1:3:2, 1:3:2), 4), 3), 2)
  end function sum_corners

  !> Nodes on equal steps of the master's parameters, r fastest.
  subroutine make_nodes(build, spec)
    type(build_t), intent(inout) :: build
    type(block_spec_t), intent(in) :: spec
    real(wp) :: x(3, 3, 3, 3), f1(3), f2(3), f3(3), p(3)
    integer :: i, j, k, a, b, c, n

    call fill_master(spec, x)
    n = spec%node + product(spec%n + 1) - 1
    call grow_nodes(build%nodes, n)
    n = spec%node - 1
    do k = 0, spec%n(3)
      f3 = functions(k, spec%n(3))
      do j = 0, spec%n(2)
        f2 = functions(j, spec%n(2))
        do i = 0, spec%n(1)
          f1 = functions(i, spec%n(1))
          p = 0.0_wp
          do c = 1, 3
            do b = 1, 3
              do a = 1, 3
                p = p + f1(a)*f2(b)*f3(c)*x(:, a, b, c)
              end do
            end do
          end do
          n = n + 1
          build%nodes%x(:, n) = matmul(build%turn, p) + build%shift
          build%nodes%given(n) = .true.
          build%nodes%weight(n) = 0.0_wp
        end do
      end do
    end do
    build%nodes%top = max(build%nodes%top, n)
    build%last_node = n
  end subroutine make_nodes

  !> Quadratic functions at step i of n from -1 to 1.
  pure function functions(i, n) result(f)
    integer, intent(in) :: i, n
    real(wp) :: f(3), s

    s = (2*i - n)/real(n, wp)
    f = [0.5_wp*s*(s - 1.0_wp), 1.0_wp - s*s, 0.5_wp*s*(s + 1.0_wp)]
  end function functions

  !> Elements, r fastest; a mirroring TRANsform exchanges their lower and upper faces.
  subroutine make_elements(build, spec)
    type(build_t), intent(inout) :: build
    type(block_spec_t), intent(in) :: spec
    integer :: m, nen, i, j, k, a, b, c, e, at, box(27), node(27)

    m = merge(1, 2, spec%type == BRICK_8)
    nen = merge(8, 27, m == 1)
    call grow_elements(build%elements, spec%element + product(spec%n/m) - 1, nen)
    e = spec%element - 1
    do k = 0, spec%n(3) - m, m
      do j = 0, spec%n(2) - m, m
        do i = 0, spec%n(1) - m, m
          at = 0
          do c = k, k + m
            do b = j, j + m
              do a = i, i + m
                at = at + 1
                box(at) = spec%node + a + (spec%n(1) + 1)*(b + (spec%n(2) + 1)*c)
              end do
            end do
          end do
          if (m == 1) then
            node(:8) = box([1, 2, 4, 3, 5, 6, 8, 7])
          else
            node = box(FEAP27)
          end if
          if (mirrored(build%turn)) node(:nen) = swapped(node(:nen))
          e = e + 1
          associate (list => build%elements)
            list%node(:, e) = 0
            list%node(:nen, e) = node(:nen)
            list%nen(e) = nen
            list%material(e) = spec%material
            list%place(e) = build%places%n
          end associate
        end do
      end do
    end do
    build%elements%top = max(build%elements%top, e)
    build%last_element = e
    build%last_material = spec%material
  end subroutine make_elements

  pure logical function mirrored(t)
    real(wp), intent(in) :: t(3, 3)

    mirrored = t(1, 1)*(t(2, 2)*t(3, 3) - t(2, 3)*t(3, 2)) &
               + t(1, 2)*(t(2, 3)*t(3, 1) - t(2, 1)*t(3, 3)) &
               + t(1, 3)*(t(2, 1)*t(3, 2) - t(2, 2)*t(3, 1)) < 0.0_wp
  end function mirrored

  !> Lower and upper face exchanged.
  pure function swapped(node) result(new)
    integer, intent(in) :: node(:)
    integer :: new(size(node))

    new = node
    new(:4) = node(5:8)
    new(5:8) = node(:4)
    if (size(node) == 8) return
    new(9:12) = node(13:16)
    new(13:16) = node(9:12)
    new(21) = node(22)
    new(22) = node(21)
  end function swapped

end module setup_block_mesh
