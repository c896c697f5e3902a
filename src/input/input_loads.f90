!> Loads that do not depend on the motion, integrated once: body forces and dead pressures.
module input_loads
  use base_kinds, only: wp
  use boundary, only: dead_load_t, pressure_t
  use element_type, only: cell_t
  use face_rule, only: face_points, face_normal
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use model, only: model_t
  use tensor, only: det3
  implicit none
  private
  public :: integrate_loads

contains

  !> One dead load a load number; follower pressures stay what they are.
  subroutine integrate_loads(model)
    type(model_t), intent(inout) :: model
    type(pressure_t), allocatable :: follower(:)
    real(wp), allocatable :: f(:, :)
    integer, allocatable :: table(:)
    integer :: i, b

    call list_tables(model, table)
    allocate (model%bc%dead(size(table)))
    do i = 1, size(table)
      if (.not. allocated(f)) allocate (f(3, model%mesh%nnode))
      f = 0.0_wp
      do b = 1, size(model%mesh%block)
        if (is_rigid(model%mesh%block(b))) cycle
        associate (set => model%material(model%mesh%block(b)%material))
          if (set%body_table == table(i) .and. any(abs(set%body_force) > 0.0_wp)) then
            if (.not. allocated(model%bc%dead(i)%place%file)) model%bc%dead(i)%place = set%place
            call add_body_force(model%mesh, model%mesh%block(b), set%body_force, f)
          end if
        end associate
      end do
      do b = 1, size(model%bc%pressure)
        associate (p => model%bc%pressure(b))
          if (p%table /= table(i) .or. p%follower) cycle
          if (.not. allocated(model%bc%dead(i)%place%file)) model%bc%dead(i)%place = p%place
          call add_pressure(model%mesh, p, f)
        end associate
      end do
      model%bc%dead(i)%table = table(i)
      call compress(f, model%bc%dead(i))
    end do
    follower = pack_followers(model%bc%pressure)
    call move_alloc(follower, model%bc%pressure)
  end subroutine integrate_loads

  !> Load numbers of the dead loads.
  pure subroutine list_tables(model, table)
    type(model_t), intent(in) :: model
    integer, allocatable, intent(out) :: table(:)
    integer :: b, k

    allocate (table(0))
    do b = 1, size(model%mesh%block)
      if (is_rigid(model%mesh%block(b))) cycle
      associate (set => model%material(model%mesh%block(b)%material))
        if (all(table /= set%body_table) .and. any(abs(set%body_force) > 0.0_wp)) then
          table = [table, set%body_table]
        end if
      end associate
    end do
    do b = 1, size(model%bc%pressure)
      k = model%bc%pressure(b)%table
      if (all(table /= k) .and. .not. model%bc%pressure(b)%follower) table = [table, k]
    end do
  end subroutine list_tables

  function pack_followers(list) result(kept)
    type(pressure_t), intent(in) :: list(:)
    type(pressure_t), allocatable :: kept(:)
    integer :: i, n

    allocate (kept(count(list%follower)))
    n = 0
    do i = 1, size(list)
      if (.not. list(i)%follower) cycle
      n = n + 1
      kept(n) = list(i)
    end do
  end function pack_followers

  !> f_a += int N_a b dV, by the rule of the block.
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

  !> f_a -= int N_a p n dA on the reference faces.
  subroutine add_pressure(mesh, p, f)
    type(mesh_t), intent(in) :: mesh
    type(pressure_t), intent(in) :: p
    real(wp), intent(inout) :: f(:, :)
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

  !> Keep the nodes that carry something.
  pure subroutine compress(f, dead)
    real(wp), intent(in) :: f(:, :)
    type(dead_load_t), intent(inout) :: dead
    integer :: n

    dead%node = pack([(n, n=1, size(f, 2))], any(abs(f) > 0.0_wp, 1))
    dead%f = f(:, dead%node)
  end subroutine compress

end module input_loads
