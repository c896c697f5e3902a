!> Masses of the elements, and inertial forces.
!!
!! The degree of rho N_a N_b is twice that of the functions, but that of the stress power is lower,
!! and the rules of tetrahedra and pyramids are made for the latter. With one point, the mass of a
!! linear tetrahedron would have the rank 1, and a turning body would have half of its energy. So
!! these elements have a rule of their own for masses (mass_points of element_t), which is exact if
!! their edges are straight.
module inertia
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use csr, only: block_matrix_t
  use dynamics_type, only: dynamics_t, HHT
  use element_type, only: cell_t, rule_t
  use mesh, only: block_t, block_cell, is_rigid
  use model, only: model_t, state_t
  use model_basis, only: tabulate_points
  use tensor, only: det3
  implicit none
  private
  public :: mass_t, find_masses, count_scaled, driven_marks, add_inertia, kinetic_energy, &
            energy_of_rate

  !> Mass matrices of the elements of one block, the same for every direction.
  type :: mass_t
    real(wp), allocatable :: m(:, :, :) !! (nen, nen, nelem) [M]
  end type mass_t

  !> A row sum of a mass matrix is taken as positive if it exceeds this part of the diagonal, so
  !! that the sign is not that of a rounding error.
  real(wp), parameter :: CLEARLY_POSITIVE = 1.0e-3_wp

contains

  !> Find consistent masses, or diagonal masses with the same sum, which are positive.
  subroutine find_masses(model, dynamics, mass)
    type(model_t), intent(in) :: model
    type(dynamics_t), intent(in) :: dynamics
    type(mass_t), allocatable, intent(out) :: mass(:)
    type(basis_t) :: better
    real(wp) :: density
    integer :: b, e

    allocate (mass(size(model%mesh%block)))
    do b = 1, size(mass)
      associate (block => model%mesh%block(b))
        if (is_rigid(block)) cycle
        density = dynamics%density
        if (density < 0.0_wp) density = model%material(block%material)%density
        allocate (mass(b)%m(block%nen, block%nen, block%nelem))
        call find_better(block, better)
        do e = 1, block%nelem
          call element_mass(block, better, e, model%mesh%xr(:, block%conn(:, e)), density, &
                            mass(b)%m(:, :, e))
          if (dynamics%lumped) call lump(mass(b)%m(:, :, e))
        end do
      end associate
    end do
  end subroutine find_masses

  !> Functions of a block at the points of the rule for masses, if the elements have such a rule and
  !! the block has none that is at least as good. All elements then have the same functions.
  subroutine find_better(block, better)
    type(block_t), intent(in) :: block
    type(basis_t), intent(out) :: better  !! nq = 0: masses have the rule of the block
    type(cell_t) :: cell
    type(rule_t) :: rule

    associate (n => block%row%mass_points)
      if (block%rule%nq >= n**3) return
      call block_cell(block, 1, cell)
      call block%row%rule(cell, n, n, rule)
      call tabulate_points(block, 1, rule%xi, rule%wgt, better)
    end associate
  end subroutine find_better

  !> Mass matrix of an element.
  pure subroutine element_mass(block, better, e, xr, density, m)
    type(block_t), intent(in) :: block
    type(basis_t), intent(in) :: better   !! of find_better
    integer, intent(in) :: e
    real(wp), intent(in) :: xr(:, :)      !! (3, nen) [L]
    real(wp), intent(in) :: density
    real(wp), intent(out) :: m(:, :)      !! (nen, nen)

    if (better%nq > 0) then
      call integrate_mass(better, xr, density, m)
    else
      call integrate_mass(block%basis(block%ibasis(e)), xr, density, m)
    end if
  end subroutine element_mass

  !> Integrate rho N_a N_b over an element.
  pure subroutine integrate_mass(basis, xr, density, m)
    type(basis_t), intent(in) :: basis
    real(wp), intent(in) :: xr(:, :)      !! (3, nen) [L]
    real(wp), intent(in) :: density
    real(wp), intent(out) :: m(:, :)      !! (nen, nen)
    real(wp) :: w
    integer :: a, q

    m = 0.0_wp
    do q = 1, basis%nq
      w = density*basis%wgt(q)*det3(matmul(xr, transpose(basis%dshp(:, :, q))))
      do a = 1, basis%nen
        m(:, a) = m(:, a) + (w*basis%shp(a, q))*basis%shp(:, q)
      end do
    end do
  end subroutine integrate_mass

  !> Replace a mass matrix by a diagonal one. Its row sums are the nodal forces of a uniform
  !! acceleration, so a body on which a uniform force per mass acts falls without stress. Where row
  !! sums are not positive, the diagonal is scaled to the same sum, which is positive for all shape
  !! functions (Hinton, Rock and Zienkiewicz 1976), and a uniform acceleration causes stress.
  pure subroutine lump(m)
    real(wp), intent(inout) :: m(:, :)
    real(wp) :: d(size(m, 1))
    integer :: a

    if (has_positive_rows(m)) then
      d = sum(m, 2)
    else
      d = [(m(a, a), a=1, size(d))]
      if (sum(d) > 0.0_wp) d = d*(sum(m)/sum(d))
    end if
    m = 0.0_wp
    do a = 1, size(d)
      m(a, a) = d(a)
    end do
  end subroutine lump

  !> Are all row sums of a mass matrix positive?
  pure logical function has_positive_rows(m) result(yes)
    real(wp), intent(in) :: m(:, :)
    integer :: a

    yes = all([(sum(m(:, a)) > CLEARLY_POSITIVE*m(a, a), a=1, size(m, 1))])
  end function has_positive_rows

  !> Number of elements of a block whose lumped masses are the scaled diagonal.
  integer function count_scaled(block, xr) result(n)
    type(block_t), intent(in) :: block
    real(wp), intent(in) :: xr(:, :)      !! (3, nnode) [L]
    type(basis_t) :: better
    real(wp), allocatable :: m(:, :)
    integer :: e

    n = 0
    if (is_rigid(block)) return
    call find_better(block, better)
    allocate (m(block%nen, block%nen))
    do e = 1, block%nelem
      call element_mass(block, better, e, xr(:, block%conn(:, e)), 1.0_wp, m)
      if (.not. has_positive_rows(m)) n = n + 1
    end do
  end function count_scaled

  !> Find the displacements whose acceleration is that of a prescribed displacement: the prescribed
  !! ones, and those of slaves with prescribed masters only.
  pure function driven_marks(model) result(driven)
    type(model_t), intent(in) :: model
    logical :: driven(3, size(model%eq, 2))
    integer :: i, j

    driven = model%eq == 0
    associate (list => model%mesh%constraint)
      do i = 1, list%n
        do j = 1, 3
          driven(j, list%slave(i)) = all(model%eq(j, list%master(list%first(i): &
                                                                 list%first(i + 1) - 1)) == 0)
        end do
      end do
    end associate
  end function driven_marks

  !> Add the inertial forces of one block of elements, and their derivative to the diagonals of the
  !! (3, 3) blocks of k. The derivatives with respect to driven displacements are those with which
  !! Newton's method applies their increments; k may be symmetric, so rows and columns have them.
  subroutine add_inertia(block, mass, dynamics, acc, driven, at, k, f)
    type(block_t), intent(in) :: block
    type(mass_t), intent(in) :: mass
    type(dynamics_t), intent(in) :: dynamics
    real(wp), intent(in) :: acc(:, :)             !! (3, nnode) acceleration [L/T^2]
    logical, intent(in) :: driven(:, :)           !! (3, nnode)
    integer, intent(in) :: at(:, :, :)            !! (nen, nen, nelem) block positions in k
    type(block_matrix_t), intent(inout) :: k
    real(wp), intent(inout) :: f(:, :)            !! (3, nnode) [F]
    real(wp) :: force(3, block%nen), factor, c, d
    integer :: a, b, e, i, p

    factor = 1.0_wp
    if (dynamics%method == HHT) factor = 1.0_wp/(1.0_wp + dynamics%alpha)
    c = factor*dynamics%c(1)
    d = factor*dynamics%d(1)
    do e = 1, block%nelem
      associate (node => block%conn(:, e))
        force = factor*matmul(acc(:, node), mass%m(:, :, e))
        do b = 1, block%nen
          f(:, node(b)) = f(:, node(b)) + force(:, b)
          do a = 1, block%nen
            p = at(a, b, e)
            if (p == 0) cycle
            do i = 1, 3
              k%val(i, i, p) = k%val(i, i, p) + mass%m(a, b, e) &
                               *merge(d, c, driven(i, node(a)) .or. driven(i, node(b)))
            end do
          end do
        end do
      end associate
    end do
  end subroutine add_inertia

  !> Kinetic energy 1/2 v.M.v at the end of the last accepted step.
  real(wp) function kinetic_energy(model, mass, state) result(energy)
    type(model_t), intent(in) :: model
    type(mass_t), intent(in) :: mass(:)
    type(state_t), intent(in) :: state

    energy = 0.0_wp
    if (state%dynamics%on) energy = energy_of_rate(model, mass, state%dynamics%v)
  end function kinetic_energy

  !> Energy 1/2 v.M.v of a velocity v.
  real(wp) function energy_of_rate(model, mass, v) result(energy)
    type(model_t), intent(in) :: model
    type(mass_t), intent(in) :: mass(:)
    real(wp), intent(in) :: v(:, :)               !! (3, nnode)
    integer :: b, e

    energy = 0.0_wp
    do b = 1, size(mass)
      if (.not. allocated(mass(b)%m)) cycle
      do e = 1, model%mesh%block(b)%nelem
        associate (node => model%mesh%block(b)%conn(:, e))
          energy = energy + 0.5_wp*sum(v(:, node)*matmul(v(:, node), mass(b)%m(:, :, e)))
        end associate
      end do
    end do
  end function energy_of_rate

end module inertia
