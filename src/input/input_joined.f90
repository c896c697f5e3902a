!> Tells whether two faces that touch are joined by common nodes, and whether these join them
!! everywhere. Faces with different functions, such as those of a spline patch and of linear
!! elements, come apart between common nodes.
module input_joined
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use mesh, only: mesh_t, is_rigid
  use surface_basis, only: surface_functions_at
  implicit none
  private
  public :: is_joined, is_held, differ, find_rigid_nodes, meet

  !> Functions are equal if they differ by less than this. Knots of a deck may be rounded.
  real(wp), parameter :: EQUAL = 0.01_wp

contains

  !> Do all nodes of one of two faces belong to the other face too?
  pure logical function is_joined(s, e, f)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e, f
    integer :: i

    associate (own => s%node(s%first(e):s%first(e + 1) - 1), &
               other => s%node(s%first(f):s%first(f + 1) - 1))
      is_joined = all([(any(other == own(i)), i=1, size(own))])
      if (.not. is_joined) is_joined = all([(any(own == other(i)), i=1, size(other))])
    end associate
  end function is_joined

  !> Do two faces have a common node?
  pure logical function meet(s, e, f)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e, f
    integer :: i

    meet = any([(any(s%node(s%first(e):s%first(e + 1) - 1) == s%node(i)), &
                 i=s%first(f), s%first(f + 1) - 1)])
  end function meet

  !> Do all nodes of face e belong to a rigid body? Then the face moves with it, whatever its
  !! functions are.
  pure logical function is_held(s, e, rigid_body, body)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e
    integer, intent(in) :: rigid_body(:) !! (nnode) from find_rigid_nodes
    integer, intent(in) :: body

    is_held = all(rigid_body(s%node(s%first(e):s%first(e + 1) - 1)) == body)
  end function is_held

  !> Find the rigid body of each node.
  pure subroutine find_rigid_nodes(mesh, rigid_body)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: rigid_body(:) !! (nnode) 0: none
    integer :: b, e

    allocate (rigid_body(mesh%nnode), source=0)
    do b = 1, size(mesh%block)
      if (.not. is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        rigid_body(mesh%block(b)%conn(:, e)) = mesh%block(b)%body
      end do
    end do
  end subroutine find_rigid_nodes

  !> Do the functions of two faces differ at a point of both?
  pure logical function differ(s, e, xi, f, eta)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e, f
    real(wp), intent(in) :: xi(2), eta(2) !! parameters of the point in the two faces
    real(wp), allocatable :: n(:), m(:)
    integer :: i

    allocate (n, source=functions_at(s, e, xi))
    allocate (m, source=functions_at(s, f, eta))
    associate (own => s%node(s%first(e):s%first(e + 1) - 1), &
               other => s%node(s%first(f):s%first(f + 1) - 1))
      ! a collapsed face has some nodes twice, and their functions are added
      differ = any([(abs(sum(n, own == own(i)) - sum(m, other == own(i))), i=1, size(own))] > EQUAL)
      if (differ) return
      differ = any([(abs(sum(n, own == other(i)) - sum(m, other == other(i))), i=1, size(other))] &
                   > EQUAL)
    end associate
  end function differ

  !> The functions of the nodes of a face at one of its points, with their weights.
  pure function functions_at(s, e, xi) result(n)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp) :: n(s%first(e + 1) - s%first(e))
    real(wp) :: slope(2, size(n))

    call surface_functions_at(s%basis(s%ibasis(e)), xi, n, slope)
    if (.not. allocated(s%w)) return
    n = n*s%w(s%first(e):s%first(e + 1) - 1)
    n = n/sum(n)
  end function functions_at

end module input_joined
