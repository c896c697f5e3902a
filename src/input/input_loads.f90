!> Loads that do not depend on the deformation, integrated once: body forces and dead pressures.
module input_loads
  use base_kinds, only: wp
  use boundary, only: pressure_t
  use element_type, only: cell_t
  use face_rule, only: face_points, face_normal
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use model, only: model_t
  use tensor, only: det3
  implicit none
  private
  public :: integrate_loads, add_pressure

contains

  !> Integrate the dead loads of each load number into one load. Follower pressures are not
  !! integrated here; only they remain in `bc%pressure`.
  subroutine integrate_loads(model)
    type(model_t), intent(inout) :: model
    type(pressure_t), allocatable :: follower(:)
    real(wp), allocatable :: f(:, :) ! (3, nnode) [F]
    integer, allocatable :: table(:)
    integer :: i, b, n

    associate (mesh => model%mesh, bc => model%bc)
      allocate (table(0))
      do b = 1, size(mesh%block)
        if (is_rigid(mesh%block(b))) cycle
        associate (set => model%material(mesh%block(b)%material))
          if (all(table /= set%body_table) .and. any(abs(set%body_force) > 0.0_wp)) then
            table = [table, set%body_table]
          end if
        end associate
      end do
      do b = 1, size(bc%pressure)
        if (bc%pressure(b)%follower .or. any(table == bc%pressure(b)%table)) cycle
        table = [table, bc%pressure(b)%table]
      end do
      allocate (bc%dead(size(table)))
      if (size(table) > 0) allocate (f(3, mesh%nnode))
      do i = 1, size(table)
        f = 0.0_wp
        associate (dead => bc%dead(i))
          do b = 1, size(mesh%block)
            if (is_rigid(mesh%block(b))) cycle
            associate (set => model%material(mesh%block(b)%material))
              if (set%body_table /= table(i) .or. .not. any(abs(set%body_force) > 0.0_wp)) cycle
              if (.not. allocated(dead%place%file)) dead%place = set%place
              call add_body_force(mesh, mesh%block(b), set%body_force, f)
            end associate
          end do
          do b = 1, size(bc%pressure)
            associate (p => bc%pressure(b))
              if (p%table /= table(i) .or. p%follower) cycle
              if (.not. allocated(dead%place%file)) dead%place = p%place
              call add_pressure(mesh, p, f)
            end associate
          end do
          dead%table = table(i)
          dead%node = pack([(n, n=1, mesh%nnode)], any(abs(f) > 0.0_wp, 1))
          dead%f = f(:, dead%node)
        end associate
      end do
      follower = bc%pressure(pack([(b, b=1, size(bc%pressure))], bc%pressure%follower))
      call move_alloc(follower, bc%pressure)
    end associate
  end subroutine integrate_loads

  !> Add a body force, f_a += int N_a b dV, integrated by the rule of the block.
  subroutine add_body_force(mesh, block, force, f)
    type(mesh_t), intent(in) :: mesh
    type(block_t), intent(in) :: block
    real(wp), intent(in) :: force(3)     !! [F/L^3]
    real(wp), intent(inout) :: f(:, :)   !! (3, nnode) [F]
    real(wp) :: jac(3, 3), dv
    integer :: e, q, a

    do e = 1, block%nelem
      associate (basis => block%basis(block%ibasis(e)), conn => block%conn(:, e))
        do q = 1, basis%nq
          jac = matmul(mesh%xr(:, conn), transpose(basis%dshp(:, :, q)))
          dv = det3(jac)*basis%wgt(q)
          do a = 1, block%nen
            f(:, conn(a)) = f(:, conn(a)) + basis%shp(a, q)*dv*force
          end do
        end do
      end associate
    end do
  end subroutine add_body_force

  !> Add a pressure, f_a -= int N_a p n dA, integrated over the reference faces.
  subroutine add_pressure(mesh, p, f)
    type(mesh_t), intent(in) :: mesh
    type(pressure_t), intent(in) :: p
    real(wp), intent(inout) :: f(:, :)   !! (3, nnode) [F]
    type(cell_t) :: cell
    real(wp), allocatable :: xi(:, :), w(:), shp(:), dshp(:, :)
    real(wp) :: area(3), t1(3), t2(3)
    integer :: i, q, a

    do i = 1, size(p%elem)
      associate (block => mesh%block(p%block(i)))
        call block_cell(block, p%elem(i), cell)
        call face_points(cell%degree, block%rule%xi, p%side(i), xi, w)
        allocate (shp(block%nen), dshp(3, block%nen))
        do q = 1, size(w)
          call block%row%functions(cell, xi(:, q), shp, dshp)
          call face_normal(p%side(i), mesh%xr(:, block%conn(:, p%elem(i))), dshp, area, t1, t2)
          do a = 1, block%nen
            associate (n => block%conn(a, p%elem(i)))
              f(:, n) = f(:, n) - p%value*w(q)*shp(a)*area
            end associate
          end do
        end do
        deallocate (shp, dshp)
      end associate
    end do
  end subroutine add_pressure

end module input_loads
