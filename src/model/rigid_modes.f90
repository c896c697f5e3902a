!> Bodies that their supports do not fully restrain, and the rigid motions that remain possible.
!!
!! A body is a set of elements that are connected by common nodes or by constraints of nodes. Its
!! small rigid motions are u(x) = t + cross(w, x - centre)/size, with six coefficients (t, w). The
!! motions that remain possible are those for which u vanishes at every prescribed dof.
module rigid_modes
  use base_kinds, only: wp
  use base_text, only: to_text
  use contact_pair, only: contact_t
  use lapack, only: dsyev
  use mesh, only: mesh_t, is_rigid
  use model, only: model_t
  use tensor, only: cross
  implicit none
  private
  public :: free_body_t, find_free_bodies, is_within_body, find_motions, rigid_motion, &
            motion_text, list_text, null_vectors, find_pieces, find_bodies

  !> Eigenvalues of a matrix of supports below this limit are taken as zero. The matrix of a single
  !! support has one nonzero eigenvalue, which lies between 1 and 2.
  real(wp), parameter :: UNHELD = 1.0e-12_wp
  !> Components of a direction below this limit are shown as zero in messages.
  real(wp), parameter :: SMALL = 1.0e-3_wp

  type :: free_body_t
    character(:), allocatable :: name  !! such as: body 'ball'
    integer, allocatable :: node(:)    !! its nodes in ascending order, without slaves
    logical :: in_contact = .false.    !! one of its faces belongs to a CONTact
    logical :: bonded = .false.        !! one of its faces belongs to a CONTact with COHEsive
    real(wp) :: centre(3) = 0.0_wp     !! mean position of the supported nodes, or else of all [L]
    real(wp) :: size = 0.0_wp          !! largest distance of a node from the centre [L]
    integer :: nmotion = 0             !! number of motions that the supports permit
    real(wp) :: motion(6, 6) = 0.0_wp  !! (t, w) of each of these motions, orthonormal [-]
  end type free_body_t

contains

  !> Find the bodies that can move as rigid bodies when the nodes are at the positions x.
  subroutine find_free_bodies(model, x, body)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(free_body_t), allocatable, intent(out) :: body(:)
    type(free_body_t), allocatable :: all_of(:)
    integer, allocatable :: piece(:), index_of(:)
    integer :: b, c, k, n, npiece

    call find_pieces(model%mesh, piece)
    npiece = maxval(piece)
    allocate (all_of(npiece))
    do n = 1, npiece
      all_of(n)%node = pack([(k, k=1, size(piece))], piece == n)
    end do
    do c = 1, size(model%contact)
      if (touches_one_body(model%contact(c), piece)) cycle
      do k = 1, 2
        associate (side => model%contact(c)%side(k))
          if (side%rigid) cycle
          do n = 1, size(side%node)
            b = piece(side%node(n))
            if (b == 0) cycle
            all_of(b)%in_contact = .true.
            if (model%contact(c)%cohesive%given) all_of(b)%bonded = .true.
          end do
        end associate
      end do
    end do
    allocate (index_of(0))
    do b = 1, npiece
      call leave_slaves(model%mesh, all_of(b)%node)
      call find_motions(model%eq, x, all_of(b))
      if (all_of(b)%nmotion == 0) cycle
      call name_body(model%mesh, piece, b, all_of(b)%name)
      index_of = [index_of, b]
    end do
    allocate (body(size(index_of)))
    do b = 1, size(body)
      body(b) = all_of(index_of(b))
    end do
  end subroutine find_free_bodies

  !> Is a contact the self-contact of a single body, so that it cannot restrain other bodies?
  logical function is_within_body(model, c) result(yes)
    type(model_t), intent(in) :: model
    integer, intent(in) :: c
    integer, allocatable :: piece(:)

    yes = model%contact(c)%self
    if (.not. yes) return
    call find_pieces(model%mesh, piece)
    yes = touches_one_body(model%contact(c), piece)
  end function is_within_body

  pure logical function touches_one_body(contact, piece) result(yes)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: piece(:)      !! (nnode)

    associate (node => contact%side(1)%node)
      yes = contact%self .and. all(piece(node) == piece(node(1)))
    end associate
  end function touches_one_body

  !> Number the connected pieces of the mesh.
  subroutine find_pieces(mesh, piece)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: piece(:) !! (nnode) piece of each node; 0: the node belongs
    !! to no deformable element
    integer, allocatable :: root(:)
    integer :: b, e, i, n, npiece

    allocate (root(mesh%nnode), source=0)
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      associate (conn => mesh%block(b)%conn)
        do e = 1, mesh%block(b)%nelem
          do i = 1, size(conn, 1)
            call join(conn(1, e), conn(i, e))
          end do
        end do
      end associate
    end do
    do n = 1, mesh%constraint%n
      do i = mesh%constraint%first(n), mesh%constraint%first(n + 1) - 1
        if (root(mesh%constraint%slave(n)) == 0 .or. root(mesh%constraint%master(i)) == 0) cycle
        call join(mesh%constraint%slave(n), mesh%constraint%master(i))
      end do
    end do
    allocate (piece(mesh%nnode), source=0)
    npiece = 0
    do n = 1, mesh%nnode
      if (root(n) == 0) cycle
      i = top(n)
      if (piece(i) == 0) then
        npiece = npiece + 1
        piece(i) = npiece
      end if
      piece(n) = piece(i)
    end do

  contains

    !> Join the sets to which two nodes belong.
    subroutine join(a, b)
      integer, intent(in) :: a, b
      integer :: ra, rb

      if (root(a) == 0) root(a) = a
      if (root(b) == 0) root(b) = b
      ra = top(a)
      rb = top(b)
      root(max(ra, rb)) = min(ra, rb)
    end subroutine join

    !> The node that represents the set to which node a belongs.
    integer function top(a)
      integer, intent(in) :: a

      top = a
      do while (root(top) /= top)
        root(top) = root(root(top)) ! shortens the path for later calls
        top = root(top)
      end do
    end function top

  end subroutine find_pieces

  !> Number the bodies: the pieces of find_pieces and, after them, the rigid bodies.
  subroutine find_bodies(mesh, body)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: body(:) !! (nnode) 0: the node belongs to no element
    integer :: b, e, npiece

    call find_pieces(mesh, body)
    npiece = maxval(body)
    do b = 1, size(mesh%block)
      if (.not. is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        associate (node => mesh%block(b)%conn(:, e))
          where (body(node) == 0) body(node) = npiece + mesh%block(b)%body
        end associate
      end do
    end do
  end subroutine find_bodies

  !> Remove the slaves of constraints from a list of nodes, because slaves have no unknowns and do
  !! not act as supports.
  pure subroutine leave_slaves(mesh, node)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(inout) :: node(:)
    logical, allocatable :: is_free(:)

    if (mesh%constraint%n == 0) return
    allocate (is_free(mesh%nnode), source=.true.)
    is_free(mesh%constraint%slave(:mesh%constraint%n)) = .false.
    node = pack(node, is_free(node))
  end subroutine leave_slaves

  !> Find the rigid motions that the supports of a body permit when the nodes are at x.
  subroutine find_motions(eq, x, body)
    integer, intent(in) :: eq(:, :)      !! (3, nnode) equation numbers, 0: prescribed
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(free_body_t), intent(inout) :: body
    real(wp), allocatable :: kernel(:, :)
    real(wp) :: support(6, 6), row(6), unit(3), d(3)
    integer :: i, j, n, nheld

    body%centre = 0.0_wp
    nheld = 0
    do j = 1, size(body%node)
      n = body%node(j)
      if (all(eq(:, n) /= 0)) cycle
      body%centre = body%centre + x(:, n)
      nheld = nheld + 1
    end do
    if (nheld > 0) then
      body%centre = body%centre/nheld
    else
      body%centre = sum(x(:, body%node), 2)/size(body%node)
    end if
    body%size = 0.0_wp
    do j = 1, size(body%node)
      body%size = max(body%size, norm2(x(:, body%node(j)) - body%centre))
    end do
    support = 0.0_wp
    do j = 1, size(body%node)
      n = body%node(j)
      d = (x(:, n) - body%centre)/body%size
      do i = 1, 3
        if (eq(i, n) /= 0) cycle
        unit = 0.0_wp
        unit(i) = 1.0_wp
        row = [unit, cross(d, unit)]
        support = support + spread(row, 2, 6)*spread(row, 1, 6)
      end do
    end do
    call null_vectors(support, UNHELD, kernel)
    body%nmotion = size(kernel, 2)
    body%motion = 0.0_wp
    body%motion(:, :body%nmotion) = kernel
  end subroutine find_motions

  !> Orthonormal eigenvectors of a symmetric matrix that belong to eigenvalues between -limit and
  !! limit, or, with or_less, to all eigenvalues up to limit.
  subroutine null_vectors(a, limit, kernel, or_less)
    real(wp), intent(in) :: a(:, :)      !! (n, n)
    real(wp), intent(in) :: limit
    real(wp), allocatable, intent(out) :: kernel(:, :) !! (n, number of vectors)
    logical, intent(in), optional :: or_less !! include eigenvalues below -limit
    real(wp) :: vector(size(a, 1), size(a, 1)), value(size(a, 1)), work(8*size(a, 1) + 8)
    integer :: i, n, info
    logical :: all_negative

    all_negative = .false.
    if (present(or_less)) all_negative = or_less
    n = size(a, 1)
    vector = a
    if (n > 0) call dsyev('V', 'U', n, vector, n, value, work, size(work), info)
    allocate (kernel(n, 0))
    do i = 1, n
      if (value(i) > limit .or. (value(i) < -limit .and. .not. all_negative)) cycle
      kernel = reshape([kernel, vector(:, i)], [n, size(kernel, 2) + 1])
    end do
  end subroutine null_vectors

  !> Displacement of the nodes of a body in a rigid motion; it is zero at prescribed dofs.
  pure function rigid_motion(body, c, eq, x) result(u)
    type(free_body_t), intent(in) :: body
    real(wp), intent(in) :: c(6)         !! coefficients (t, w)
    integer, intent(in) :: eq(:, :)
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    real(wp) :: u(3, size(body%node))
    integer :: j, n

    do j = 1, size(body%node)
      n = body%node(j)
      u(:, j) = c(:3) + cross(c(4:), (x(:, n) - body%centre)/body%size)
      where (eq(:, n) == 0) u(:, j) = 0.0_wp
    end do
  end function rigid_motion

  !> Name a body after the patches or meshes of which it consists.
  subroutine name_body(mesh, piece, index, name)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: piece(:), index
    character(:), allocatable, intent(out) :: name
    logical :: has(0:size_of(mesh)), others(0:size_of(mesh))
    integer :: b, e, n, named

    has = .false.
    others = .false.
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        if (piece(mesh%block(b)%conn(1, e)) == index) then
          has(mesh%block(b)%body) = .true.
        else
          others(mesh%block(b)%body) = .true.
        end if
      end do
    end do
    name = ''
    named = 0
    do b = 1, size_of(mesh)
      if (.not. has(b)) cycle
      if (named > 0) name = name//', '
      name = name//"'"//mesh%body(b)%name//"'"
      named = named + 1
    end do
    if (named == 1) name = 'body '//name
    if (named > 1) name = 'the body of '//name
    if (named > 0 .and. .not. any(has .and. others)) return
    do n = 1, size(piece)
      if (piece(n) == index) exit
    end do
    if (named == 0) name = 'the body'
    name = name//' with node '//to_text(n)
  end subroutine name_body

  !> Number of bodies in the list of a mesh, which may be unallocated.
  pure integer function size_of(mesh)
    type(mesh_t), intent(in) :: mesh

    size_of = 0
    if (allocated(mesh%body)) size_of = size(mesh%body)
  end function size_of

  !> Describe a space of motions, such as: move along z, turn about x.
  function motion_text(motion, tolerance) result(text)
    real(wp), intent(in) :: motion(:, :) !! (6, m) coefficients (t, w), orthonormal
    real(wp), intent(in), optional :: tolerance !! smaller components are left out
    character(:), allocatable :: text
    real(wp), allocatable :: kernel(:, :)
    real(wp) :: turn(3, size(motion, 2)), small_part

    ! combinations of the motions with w = 0 are translations; all others contain a rotation
    turn = motion(4:, :)
    small_part = SMALL
    if (present(tolerance)) small_part = tolerance
    call null_vectors(matmul(transpose(turn), turn), small_part**2, kernel)
    text = directions(matmul(motion(:3, :), kernel), 'move along ', small_part)
    text = list_text(text, directions(turn, 'turn about ', small_part))
  end function motion_text

  !> Describe the space that the columns of v span: by coordinate axes if it is spanned by such
  !! axes, otherwise by an orthonormal basis.
  function directions(v, verb, small_part) result(text)
    real(wp), intent(in) :: v(:, :)      !! (3, m)
    character(*), intent(in) :: verb
    real(wp), intent(in) :: small_part
    character(:), allocatable :: text
    real(wp) :: basis(3, 3), d(3)
    integer :: i, j, n, named

    ! orthonormal basis, by Gram and Schmidt
    n = 0
    do i = 1, size(v, 2)
      d = v(:, i)
      do j = 1, n
        d = d - dot_product(basis(:, j), d)*basis(:, j)
      end do
      if (.not. norm2(d) > small_part .or. n == 3) cycle
      n = n + 1
      basis(:, n) = d/norm2(d)
      do j = 1, n - 1
        basis(:, n) = basis(:, n) - dot_product(basis(:, j), basis(:, n))*basis(:, j)
      end do
      basis(:, n) = basis(:, n)/norm2(basis(:, n))
    end do
    text = ''
    named = 0
    do i = 1, 3
      if (n == 0) return
      if (norm2(basis(i, :n)) < sqrt(1.0_wp - small_part**2)) cycle
      text = list_text(text, verb//'xyz' (i:i))
      named = named + 1
    end do
    if (named == n) return
    text = ''
    do j = 1, n
      d = basis(:, j)
      where (abs(d) < small_part) d = 0.0_wp
      if (d(maxloc(abs(d), 1)) < 0.0_wp) d = -d
      text = list_text(text, verb//'('//to_text(d(1), 3)//', '//to_text(d(2), 3)//', ' &
                       //to_text(d(3), 3)//')')
    end do
  end function directions

  !> Join two lists, with a comma between them unless one is empty.
  pure function list_text(a, b) result(text)
    character(*), intent(in) :: a, b
    character(:), allocatable :: text

    text = a//b
    if (len(a) > 0 .and. len(b) > 0) text = a//', '//b
  end function list_text

end module rigid_modes
